#include "server/jobs/comparisons.h"

#include "image/encode.h"
#include "measures/displayed.h"
#include "server/api/comparison_json.h"
#include "server/api/frame_json.h"
#include "server/api/frames.h"
#include "server/api/job_routes.h"
#include "server/jobs/job_work.h"
#include "server/service.h"

#include <nlohmann/json.hpp>

#include <cmath>

namespace clerestory {
namespace {

// Tracing takes most of a comparison.
constexpr double kTracingShare = 0.7;

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

// As a frame of the request would show it.
Image displayedReference(const ReferenceRender& truth, const FrameRequest& frame) {
    const auto factor = static_cast<float>(std::exp2(frame.exposure));
    return quantised(displayed(truth.image.color, frame.toneMap, factor));
}

JobResult resultOf(const Comparison& comparison, const Image& truth, const std::string& job) {
    JobResult result;
    std::vector<std::string> links;
    for (const SettingResult& setting : comparison.settings) {
        if (setting.errorPicture.data.empty()) continue;
        links.push_back("/v1/jobs/" + job + "/pictures/" + std::to_string(links.size()));
        result.pictures.push_back({"image/png", encodePng(setting.errorPicture)});
    }
    nlohmann::ordered_json json = comparisonJson(comparison, links);
    if (!links.empty()) {
        json["reference"]["picture"] =
            "/v1/jobs/" + job + "/pictures/" + std::to_string(links.size());
        result.pictures.push_back({"image/png", encodePng(truth)});
    }
    result.json = json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
    return result;
}

JobResult compared(Service& service, const ComparisonRequest& request, const std::string& job,
                   const JobControl& control) {
    const auto scene = service.library().require(request.frame.scene);
    const auto truth = service.truths().find(truthKey(service, *scene, request), [&] {
        return tracedReference(
            service, request.frame, request.mode, request.samples, request.seed,
            [&](double share) { return control.proceed(kTracingShare * share); });
    });
    if (!truth) return {};
    try {
        const auto comparison = compare(
            request, *scene, *truth,
            [&](const FrameRequest& frame) { return drawnBetween(service, frame, control); },
            [&](double share) {
                return control.proceed(kTracingShare + (1.0 - kTracingShare) * share);
            });
        if (!comparison) return {};
        return resultOf(*comparison, displayedReference(*truth, request.frame), job);
    } catch (const JobCancelled&) {
        return {};
    }
}

}  // namespace

Answer postComparison(Service& service, const Call& call) {
    requireJsonType(call);
    requireQuery(call, false);
    ComparisonRequest request = comparisonRequestFrom(strictJson(call.body));
    const auto scene = service.library().require(request.frame.scene);
    request.frame.scene = scene->id;
    // What no table can know, a camera's name and the like, is told now and not in the job.
    service.queue().run(turnOf(service, call), [frame = request.frame](Renderer& renderer) {
        return renderer.plan(frame).passes.size();
    });
    const auto work = [&service, request](const std::string& id) {
        return [&service, request, id](const JobControl& control) {
            return compared(service, request, id, control);
        };
    };
    return accepted(service.jobs().start(work, call.job));
}

}  // namespace clerestory
