#include "server/jobs/job_work.h"

#include "server/base/problem.h"

namespace clerestory {
namespace {

// A frame of a job may take long.
constexpr std::chrono::seconds kFramePatience{300};
constexpr std::chrono::milliseconds kRetryInterval{200};

}  // namespace

std::shared_ptr<const ReferenceRender> traceReference(SceneLibrary& library,
                                                      const FrameRequest& frame, ReferenceMode mode,
                                                      std::uint32_t samples, std::uint64_t seed,
                                                      const std::function<bool(double)>& progress) {
    const auto start = Clock::now();
    const Scene scene = library.whole(frame.scene);
    EnvironmentMaps maps;
    for (const std::string& name : library.environmentNames()) {
        maps[name] = library.environment(name);
    }
    const auto lighting = maps.find(frame.environment.map.value_or(scene.environment));
    if (lighting == maps.end()) {
        throw InvalidRequest({{"/environment/map", "is not the name of a loaded map",
                               "a name that GET /v1/renderer lists"}});
    }
    auto image = traceReference({.scene = scene,
                                 .frame = frame,
                                 .environment = *lighting->second,
                                 .maps = maps,
                                 .mode = mode,
                                 .samples = samples,
                                 .seed = seed},
                                progress);
    if (!image) return nullptr;
    return std::make_shared<const ReferenceRender>(
        ReferenceRender{*std::move(image), millisecondsSince(start)});
}

DrawnFrame drawTimed(Renderer& renderer, const FrameRequest& request) {
    const auto start = Clock::now();
    Frame frame = renderer.render(request);
    return {std::move(frame.image), millisecondsSince(start), std::move(frame.plan)};
}

DrawnFrame drawInQueue(const JobResources& resources, const FrameRequest& request,
                       const JobControl& control) {
    for (;;) {
        if (!control.proceed(0.0)) throw JobCancelled{};
        try {
            const auto scene = resources.library.require(request.scene);
            return resources.queue.run(kFramePatience, [request](Renderer& renderer) {
                return drawTimed(renderer, request);
            });
        } catch (const RequestError& error) {
            const std::string& code = error.problem().code;
            if (code != queueFull(1).code && code != stillLoading("").code) throw;
        }
        std::this_thread::sleep_for(kRetryInterval);
    }
}

}  // namespace clerestory
