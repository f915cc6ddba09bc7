// `clerestory compile`: fills the shader cache, so that the first frames of scenes need no
// compilation.
#include "server/cli/command_input.h"
#include "server/cli/commands.h"
#include "server/scenes/compile_ahead.h"
#include "server/scenes/shader_cache.h"

#include "scene/builtin/builtin_scenes.h"

#include <iostream>

namespace clerestory {
namespace {

void compileScene(const CommandLine& line, Renderer& renderer, const std::string& source) {
    CommandLine sceneLine = line;
    sceneLine.frame.scene = source;
    FrameRequest request;
    const EnvironmentMaps maps = environmentsOf(line, request);
    Scene scene = sceneFor(sceneLine, maps);
    scene.id = source;
    std::vector<std::shared_ptr<const EnvironmentMap>> list;
    for (const auto& [name, map] : maps) list.push_back(map);
    for (const auto& map : list) renderer.addEnvironment(map);
    const std::vector<FrameRequest> frames = firstFramesOf(scene);
    std::unique_ptr<CompileAhead> ahead;
    if (CompileAhead::helps(renderer.identity())) {
        ahead = std::make_unique<CompileAhead>(line.config.renderer, copyWithoutTexels(scene), list,
                                               frames);
    }
    renderer.addScene(std::move(scene));
    const RendererCounters before = renderer.counters();
    WarmUp warmUp = renderer.beginWarmUp(frames);
    while (renderer.advance(warmUp)) {
    }
    const RendererCounters after = renderer.counters();
    renderer.removeScene(source);
    setCompiled(source);
    std::cout << source << ": " << after.programsMade - before.programsMade << " programs, "
              << after.pipelinesMade - before.pipelinesMade << " pipelines" << std::endl;
}

}  // namespace

int runCompile(const CommandLine& line) {
    std::vector<std::string> scenes = line.compileScenes;
    if (scenes.empty()) {
        for (const BuiltinScene& scene : builtinScenes()) scenes.push_back(scene.id);
    }
    Renderer renderer(line.config.renderer);
    for (const std::string& scene : scenes) compileScene(line, renderer, scene);
    return 0;
}

}  // namespace clerestory
