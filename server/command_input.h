// What the commands without a server read: the scene, and the request.
#pragma once

#include "server/config.h"

#include "plan/frame_request.h"
#include "scene/scene.h"

namespace clerestory {

// A built-in scene's id, or a model file. Throws std::runtime_error.
Scene sceneFor(const std::string& source);

// The request file with the flags over it; the output's extension tells the format. Throws
// RequestError, and std::runtime_error for an extension that no format has.
FrameRequest requestFor(const FrameCommand& command);

}  // namespace clerestory
