// Commands for those who run a server. `clerestory serve` runs it until SIGINT or SIGTERM;
// `compile` fills the shader cache, so that the first frames of scenes need no compilation; `sign`
// signs a link that is valid for a limited time.
#include "server/cli/commands.h"

#include "server/base/log.h"
#include "server/http/access.h"
#include "server/http/listener.h"
#include "server/scenes/compile_ahead.h"
#include "server/scenes/shader_cache.h"
#include "server/server.h"

#include "scene/builtin/builtin_scenes.h"

#include <unistd.h>

#include <csignal>
#include <cstdlib>
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
    renderer.expectCompilation(source, true);
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

int runServe(const CommandLine& line) {
    // Blocked before any thread starts, so that only sigwait() below receives them.
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    std::signal(SIGHUP, SIG_IGN);  // closing the terminal does not stop the server

    logWithoutWaiting();
    setLogLevel(line.config.logLevel);
    Config config = line.config;
    config.workers.compileFastFirst =
        config.fastStart && !compiledBefore(firstSourceOf(config.scenes));
    Server server(config);
    server.start();
    std::cout << "Clerestory listens on http://" << authorityOf(config.http.host, server.port())
              << "/" << std::endl;

    int signal = 0;
    sigwait(&signals, &signal);
    logInfo({"stopping: waiting for running frames"});
    // A second signal terminates the program immediately.
    pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
    server.stop();
    // Every request is answered. An import would delay the end; it runs in a child process, which
    // ends with this one.
    if (server.backend().importing()) std::_Exit(0);
    return 0;
}

int runCompile(const CommandLine& line) {
    std::vector<std::string> scenes = line.compileScenes;
    if (scenes.empty()) {
        for (const BuiltinScene& scene : builtinScenes()) scenes.push_back(scene.id);
    }
    Renderer renderer(line.config.renderer);
    for (const std::string& scene : scenes) compileScene(line, renderer, scene);
    return 0;
}

int runSign(const CommandLine& line) {
    const auto now = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
    std::cout << signedLink(secretFrom(line.sign.keyFile), line.sign.link,
                            now + std::chrono::seconds(line.sign.validSeconds))
              << "\n";
    return 0;
}

}  // namespace clerestory
