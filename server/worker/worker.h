// The worker's side: a process that owns the renderer and the scenes, and answers the calls that
// come through its pipe. It ends when its front does.
#pragma once

#include "server/config.h"

namespace clerestory {

// What stands for `serve` on a worker's command line, and where it finds its pipe.
inline constexpr const char* kWorkerCommand = "worker";
inline constexpr int kWorkerSocket = 3;

// Answers calls until the front ends; returns the exit code.
int runWorker(const Config& config);

}  // namespace clerestory
