#include "server/comparisons.h"

#include "image/encode.h"
#include "server/comparison_json.h"
#include "server/frame_json.h"
#include "server/frames.h"
#include "server/job_routes.h"
#include "server/service.h"

#include <nlohmann/json.hpp>

namespace clerestory {
namespace {

// Tracing takes most of a comparison.
constexpr double kTracingShare = 0.7;
// A frame of a comparison may be dear; frames of clients go between.
constexpr std::chrono::seconds kFramePatience{300};
constexpr std::chrono::milliseconds kBusyPause{200};

struct Cancelled {};

// All that changes a bit of the truth.
std::string truthKey(Service& service, const Scene& scene, const ComparisonRequest& request) {
    FrameRequest frame = request.frame;
    frame.accuracy = {};
    frame.output = {};
    frame.toneMap = {};
    frame.exposure = 0.0;
    return contentText(service, scene, frame) + '\n' +
           std::to_string(static_cast<int>(request.mode)) + '\n' + std::to_string(request.samples) +
           '\n' + std::to_string(request.seed);
}

std::shared_ptr<const Truth> trace(Service& service, const ComparisonRequest& request,
                                   const std::string& environment, const JobControl& control) {
    const auto start = Clock::now();
    const Scene scene = service.library().whole(request.frame.scene);
    const auto lighting = service.library().environment(environment);
    if (!lighting) {
        throw InvalidRequest({{"/environment/map", "is not the name of a loaded map",
                               "a name that GET /v1/renderer lists"}});
    }
    EnvironmentMaps maps;
    for (const std::string& name : service.library().environmentNames()) {
        maps[name] = service.library().environment(name);
    }
    auto image =
        traceReference({.scene = scene,
                        .frame = request.frame,
                        .environment = *lighting,
                        .maps = maps,
                        .mode = request.mode,
                        .samples = request.samples,
                        .seed = request.seed},
                       [&](double share) { return control.proceed(kTracingShare * share); });
    if (!image) return nullptr;
    return std::make_shared<const Truth>(Truth{*std::move(image), millisecondsSince(start)});
}

// Frames of clients are served between those of a comparison.
DrawnFrame drawnBetween(Service& service, const FrameRequest& request, const JobControl& control) {
    for (;;) {
        if (!control.proceed(0.0)) throw Cancelled{};
        try {
            return service.queue().run(kFramePatience, [request](Renderer& renderer) {
                const auto start = Clock::now();
                Frame frame = renderer.render(request);
                return DrawnFrame{std::move(frame.image), millisecondsSince(start),
                                  std::move(frame.plan)};
            });
        } catch (const RequestError& error) {
            if (error.problem().code != queueFull(1).code) throw;
        }
        std::this_thread::sleep_for(kBusyPause);
    }
}

JobResult resultOf(const Comparison& comparison, const std::string& job) {
    JobResult result;
    std::vector<std::string> links;
    for (const SettingResult& setting : comparison.settings) {
        if (setting.errorPicture.data.empty()) continue;
        links.push_back("/v1/jobs/" + job + "/pictures/" + std::to_string(links.size()));
        result.pictures.push_back({"image/png", encodePng(setting.errorPicture)});
    }
    result.json = comparisonJson(comparison, links)
                      .dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
    return result;
}

JobResult compared(Service& service, const ComparisonRequest& request, const std::string& job,
                   const JobControl& control) {
    const auto scene = service.library().require(request.frame.scene);
    const std::string map = request.frame.environment.map.value_or(scene->environment);
    const auto truth = service.truths().find(truthKey(service, *scene, request),
                                             [&] { return trace(service, request, map, control); });
    if (!truth) return {};
    try {
        const auto comparison = compare(
            request, *scene, *truth,
            [&](const FrameRequest& frame) { return drawnBetween(service, frame, control); },
            [&](double share) {
                return control.proceed(kTracingShare + (1.0 - kTracingShare) * share);
            });
        return comparison ? resultOf(*comparison, job) : JobResult{};
    } catch (const Cancelled&) {
        return {};
    }
}

}  // namespace

Answer postComparison(Service& service, const Call& call) {
    requireJsonType(call);
    requireQuery(call, false);
    ComparisonRequest request = comparisonRequestFrom(strictJson(call.body));
    request.frame.scene = service.library().require(request.frame.scene)->id;
    // What no table can know, a camera's name and the like, is told now and not in the job.
    service.queue().run(patience(service, call), [frame = request.frame](Renderer& renderer) {
        return renderer.plan(frame).passes.size();
    });
    return accepted(service.jobs().start([&service, request](const std::string& id) {
        return [&service, request, id](const JobControl& control) {
            return compared(service, request, id, control);
        };
    }));
}

}  // namespace clerestory
