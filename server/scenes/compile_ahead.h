// Compiles the shaders of some frames on a second thread with its own OpenGL context, from the last
// step to the first, while the renderer compiles from the first to the last. Both use the driver's
// shader cache.
#pragma once

#include "renderer.h"

#include <atomic>
#include <thread>

namespace clerestory {

class CompileAhead {
public:
    // Whether a second thread saves time: the driver is software and has a cache, and there are
    // several processors.
    static bool helps(const RendererIdentity& identity);

    // The texels of the scene's textures are not needed. `proceed` is called on the thread before
    // each step; it ends when this returns false.
    CompileAhead(
        const RendererOptions& options, Scene scene,
        std::vector<std::shared_ptr<const EnvironmentMap>> maps, std::vector<FrameRequest> frames,
        std::function<bool()> proceed = [] { return true; });
    ~CompileAhead();  // waits for the present step
    CompileAhead(const CompileAhead&) = delete;
    CompileAhead& operator=(const CompileAhead&) = delete;

    void stop() { stopping_ = true; }
    bool ended() const { return ended_; }

private:
    void run(RendererOptions options, Scene scene,
             const std::vector<std::shared_ptr<const EnvironmentMap>>& maps,
             const std::vector<FrameRequest>& frames, const std::function<bool()>& proceed);

    std::atomic<bool> stopping_{false}, ended_{false};
    std::thread thread_;
};

// A copy without the texels of the textures. The scene is unchanged when this returns.
Scene copyWithoutTexels(Scene& scene);

}  // namespace clerestory
