#include "server/backend/local_backend.h"

#include "scene/hash.h"
#include "server/api/encode_answer.h"
#include "server/api/frame_json.h"
#include "server/api/frames.h"
#include "server/api/job_routes.h"

#include <nlohmann/json.hpp>

#include <algorithm>

namespace clerestory {
namespace {

// That wait or run; each can take minutes.
constexpr std::size_t kMaxJobs = 8;
// How long a frame waits for its light; see FrameOrder::wholeLight.
constexpr std::chrono::minutes kLightPatience{2};

RendererOptions rendererOf(const LocalBackendOptions& options) {
    RendererOptions renderer = options.renderer;
    renderer.light.begin = [work = options.work](const std::string& scene) {
        return work->begin("the light of " + scene);
    };
    return renderer;
}

}  // namespace

LocalBackend::LocalBackend(const LocalBackendOptions& options)
    : queue_(rendererOf(options), options.queue),
      library_(options.scenes, queue_, options.renderer, options.work),
      canary_(queue_),
      jobResources_{queue_, library_,
                    [this](const FrameRequest& request) {
                        const auto scene = library_.require(request.scene);
                        return contentText(queue_, library_, *scene, library_.requireParts(request),
                                           request);
                    }},
      budgets_(jobs_, jobResources_, options.curves),
      comparisons_(jobs_, jobResources_),
      frames_({queue_, library_, budgets_, metrics_, canary_},
              {options.limits.deadlineSeconds, options.renderer.maxShadedSamples}),
      jobs_(kMaxJobs) {
    addRoutes(routes_, FrameRoutes{frames_, options.signedLinks});
    addRoutes(routes_, JobRoutes{frames_, jobs_, comparisons_});
    addRoutes(routes_, RendererRoutes{queue_, library_, jobs_, metrics_, canary_, options.limits});
    std::string text = rendererText(queue_);  // throws when there is no driver
    for (const std::string& map : library_.environments().names()) {
        text += '\n' + map + ' ' + std::to_string(library_.environments().hash(map));
    }
    rendererHash_ = hashOf(text);
}

Answer LocalBackend::answer(const Call& call) {
    std::string route;
    Answer answer = guarded(call, [&] {
        auto found = routes_.answer(call, route);
        if (!found) throw RequestError(notFound("There is nothing at this path."));
        return *std::move(found);
    });
    answer.route = route;
    return answer;
}

std::optional<Problem> LocalBackend::refusalFor(const std::string& client) const {
    return queue_.refusalFor(client);
}

EncodedFrame LocalBackend::draw(const FrameOrder& order) {
    try {
        const FrameService::Resolved resolved =
            frames_.resolve(order.request, {order.client}, frames_.turnFor(order.arrived).patience);
        frames_.requireAffordable(resolved.request);
        Turn turn = frames_.turnFor(order.arrived);
        turn.client = order.client;
        turn.cancellation = order.cancellation;
        turn.endsInProgress =
            order.endsInProgress ? Turn::EndsInProgress::always : Turn::EndsInProgress::never;
        if (order.wholeLight && FrameService::showsLight(resolved.request)) {
            frames_.waitForLight(resolved.request, turn, kLightPatience);
            turn.patience = frames_.turnFor(Clock::now()).patience;
        }
        FrameService::Drawn drawn =
            frames_.draw(resolved, turn, Readback::picture, order.requestId);
        EncodedFrame frame{
            .type = std::string(mediaType(resolved.request.output.format)),
            .bytes = std::move(drawn.bytes),
            .milliseconds = std::max(0.0, drawn.drawMs - drawn.frame.compileMs) + drawn.encodeMs,
            .lightShare =
                FrameService::showsLight(resolved.request) ? drawn.frame.light.share : 1.0};
        if (order.withPlan) addPlan(frame, drawn.frame);
        return frame;
    } catch (const std::exception&) {
        throw RequestError(currentProblem(order.requestId));
    }
}

std::shared_ptr<const LoadedScenes> LocalBackend::loadedScenes() const {
    return std::make_shared<const LoadedScenes>(LoadedScenes{.defaultScene = library_.defaultId(),
                                                             .renderer = rendererHash_,
                                                             .scenes = library_.loadedContents()});
}

SceneReport LocalBackend::sceneReport(const std::string& id) {
    const SceneStatus status = library_.find(id);
    return {.state = status.state,
            .isKnown = status.scene != nullptr,
            .failure = status.failure,
            .reason = status.reason,
            .description = sceneDescription(library_, status)};
}

}  // namespace clerestory
