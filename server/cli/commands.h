// The commands of the program; and the input of those that run without a server: scene, request and
// environment maps; and their progress.
//
// Each command returns 0; on failure it throws an exception with a message of one line, which
// main() prints before it exits with 2.
#pragma once

#include "server/cli/config.h"

#include "plan/planner.h"
#include "scene/scene.h"

namespace clerestory {

int runServe(const CommandLine& line);
int runRender(const CommandLine& line);
int runPlan(const CommandLine& line);
int runReference(const CommandLine& line);
int runCompare(const CommandLine& line);
int runCompile(const CommandLine& line);
int runSequence(const CommandLine& line);
int runSign(const CommandLine& line);
int runScenes();
int runDevices();

// A built-in scene, or a model file with its sidecar file. Prints the warnings of the import to
// stderr. If the environment map of the scene is not in `maps`, "sky" replaces it. Throws
// std::runtime_error.
Scene sceneFor(const CommandLine& line, const EnvironmentMaps& maps);

// Waits for the light of surfaces if the request needs it. Throws if it cannot be computed.
void requireLight(Renderer& renderer, const FrameRequest& request);

// The text of the request file; {} if there is none. Throws std::runtime_error.
std::string requestText(const FrameCommand& command);

// The request file, overridden by the flags; the extension of the output selects the format. Throws
// RequestError, and std::runtime_error for an unknown extension.
FrameRequest requestFor(const FrameCommand& command);

// All maps by name. A map from the command line is used unless the request names one.
EnvironmentMaps environmentsOf(const CommandLine& line, FrameRequest& request);

// The environment map of the scene. Throws std::runtime_error if there is none of that name.
const EnvironmentMap& lightingOf(const EnvironmentMaps& maps, const Scene& scene,
                                 const FrameRequest& request);

// Progress on stderr: a line that is overwritten on a terminal, otherwise a line for every 10 %.
class ProgressLine {
public:
    explicit ProgressLine(const char* work) : work_(work) {}
    void show(double fraction);
    void end() const;

private:
    const char* work_;
    int shown_ = -10;  // percent
};

}  // namespace clerestory
