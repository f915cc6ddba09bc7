// What the commands without a server read: the scene, the request, its maps; and how far they are.
#pragma once

#include "server/cli/config.h"

#include "plan/planner.h"
#include "scene/scene.h"

namespace clerestory {

// A built-in scene, or a model file with its side file; what was left out of it is told on stderr.
// Where the map that lights it is not among `maps`, the sky does. Throws std::runtime_error.
Scene sceneFor(const CommandLine& line, const EnvironmentMaps& maps);

// The request file's text; {} when there is none. Throws std::runtime_error.
std::string requestText(const FrameCommand& command);

// The request file with the flags over it; the output's extension tells the format. Throws
// RequestError, and std::runtime_error for an extension that no format has.
FrameRequest requestFor(const FrameCommand& command);

// Every map by its name. A map that the line brings lights the scene, unless the request names one.
EnvironmentMaps environmentsOf(const CommandLine& line, FrameRequest& request);

// The map that lights the scene. Throws std::runtime_error when there is none of that name.
const EnvironmentMap& lightingOf(const EnvironmentMaps& maps, const Scene& scene,
                                 const FrameRequest& request);

// One line that overwrites itself where somebody watches it, and else one line a tenth.
class ProgressLine {
public:
    explicit ProgressLine(const char* work) : work_(work) {}
    void show(double share);
    void end() const;

private:
    const char* work_;
    int shown_ = -10;  // percent
};

}  // namespace clerestory
