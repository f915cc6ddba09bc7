// Flags of `clerestory serve` for limits, access, scenes and the renderer process.
#pragma once

#include "server/config.h"

namespace CLI {
class App;
}

namespace clerestory {

void addLimitFlags(CLI::App& serve, Config& config);
void addAccessFlags(CLI::App& serve, Config& config);
// Scenes: uploads, memory.
void addSceneFlags(CLI::App& serve, Config& config);
void addWorkerFlags(CLI::App& serve, Config& config);

}  // namespace clerestory
