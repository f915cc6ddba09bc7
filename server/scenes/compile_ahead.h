// Compiles what some frames will draw on a thread and an OpenGL context of its own, last step
// first, while the renderer that will draw them begins at the front. The two share the driver's
// shader cache.
#pragma once

#include "renderer.h"

#include <atomic>
#include <thread>

namespace clerestory {

class CompileAhead {
public:
    // Whether that is worth a thread: the driver is software, has a cache, and there are
    // processors.
    static bool helps(const RendererIdentity& identity);

    // The texels of the scene's textures are not needed, and replaced. `wanted` is asked before
    // each step, on the thread.
    CompileAhead(
        const RendererOptions& options, Scene scene,
        std::vector<std::shared_ptr<const EnvironmentMap>> maps, std::vector<FrameRequest> frames,
        std::function<bool()> wanted = [] { return true; });
    ~CompileAhead();  // ends after the step at hand
    CompileAhead(const CompileAhead&) = delete;
    CompileAhead& operator=(const CompileAhead&) = delete;

    void stop() { stopping_ = true; }
    bool ended() const { return ended_; }

private:
    void run(RendererOptions options, Scene scene,
             const std::vector<std::shared_ptr<const EnvironmentMap>>& maps,
             const std::vector<FrameRequest>& frames, const std::function<bool()>& wanted);

    std::atomic<bool> stopping_{false}, ended_{false};
    std::thread thread_;
};

// A copy without the texels of its textures, which stay where they are.
Scene copyWithoutTexels(Scene& scene);

}  // namespace clerestory
