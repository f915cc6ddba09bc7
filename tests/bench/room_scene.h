// A scene of a benchmark's command line: the room of room.h, a built-in's id or a file.
#pragma once

#include "scene/scene.h"

#include <string>

namespace clerestory::bench {

// `argument`: "room", or as loadScene() takes it. Throws what writing and loading throw.
Scene roomOrScene(const std::string& argument);

}  // namespace clerestory::bench
