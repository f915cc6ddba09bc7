#include "server/api/frame_service.h"

#include "plan/graph/work.h"
#include "scene/hash.h"
#include "server/api/encode_answer.h"
#include "server/api/frame_json.h"
#include "server/base/log.h"
#include "server/base/process.h"

#include <algorithm>

namespace clerestory {
namespace {

constexpr double kLoggedCompileMs = 100.0;
// How long a frame waits beyond its deadline while shaders are compiled.
constexpr std::chrono::seconds kCompilePatience{60};

// The contents of every environment map that a surface reflects by name.
std::string namedMapsText(const SceneLibrary& library, const Scene& scene,
                          const FrameRequest& request) {
    std::string text;
    const auto add = [&](const std::string& map) {
        if (!map.empty()) text += std::to_string(library.environments().hash(map)) + '\n';
    };
    for (const Material& m : scene.materials) add(m.environmentMap);
    for (const MaterialOverride& o : request.overrides) add(o.environmentMap.value_or(""));
    return text;
}

}  // namespace

std::string contentText(const RenderQueue& queue, const SceneLibrary& library, const Scene& scene,
                        std::span<const std::shared_ptr<const Scene>> parts,
                        const FrameRequest& request) {
    const std::string map = request.environment.map.value_or(scene.environment);
    std::string text = canonicalText(request) + '\n' + std::to_string(scene.contentHash) + '\n' +
                       std::to_string(library.environments().hash(map)) + '\n' +
                       namedMapsText(library, scene, request) + rendererText(queue);
    for (const auto& part : parts) {
        text += '\n' + std::to_string(part->contentHash) + '\n' +
                namedMapsText(library, *part, request);
    }
    return text;
}

std::uint64_t kindOf(FrameRequest request) {
    request.camera = {};
    request.time = 0.0;
    request.output = {};
    return hashOf(canonicalText(request));
}

std::string rendererText(const RenderQueue& queue) {
    const RendererIdentity& id = queue.identity();
    return buildId() + '\n' + id.vendor + '\n' + id.renderer + '\n' + id.version + '\n' +
           id.platform;
}

std::shared_ptr<const Scene> FrameService::requireScene(const std::string& id) {
    return components_.library.require(id);
}

std::vector<std::shared_ptr<const Scene>> FrameService::requireParts(const FrameRequest& request) {
    std::vector<std::shared_ptr<const Scene>> scenes;
    std::vector<FieldError> unknown;
    for (std::size_t i = 0; i < request.parts.size(); ++i) {
        try {
            scenes.push_back(requireScene(request.parts[i].scene));
        } catch (const RequestError& error) {
            const Problem& problem = error.problem();
            if (problem.code != ProblemCode::notFound || problem.errors.empty()) throw;
            unknown.push_back(problem.errors.front());
            unknown.back().pointer = "/scene/" + std::to_string(i) + "/scene";
        }
    }
    if (!unknown.empty()) throw RequestError(invalidFields(std::move(unknown)));
    return scenes;
}

FrameService::Resolved FrameService::resolve(FrameRequest request,
                                             const Budgets::Requester& requester,
                                             MapPatience patience) {
    Resolved resolved{.request = std::move(request)};
    resolved.parts = requireParts(resolved.request);
    resolved.scene = requireScene(resolved.request.scene);
    resolved.maps = components_.library.environments().requireUploads(resolved.request, patience);
    resolved.request.scene = resolved.scene->id;
    if (resolved.request.accuracy.isBudget()) {
        resolved.pick = components_.budgets.pick(resolved.request, requester);
        resolved.request.accuracy = resolved.pick->accuracy;
    }
    return resolved;
}

void FrameService::requireAffordable(const FrameRequest& request) const {
    clerestory::requireAffordable(request, limits_.mostSamples);
}

std::string FrameService::etagOf(const Resolved& resolved, std::uint32_t lightRevision) const {
    std::string text = contentText(components_.queue, components_.library, *resolved.scene,
                                   resolved.parts, resolved.request);
    if (lightRevision > 0) text += "\nlight " + std::to_string(lightRevision);
    return '"' + hashWordOf(text) + '"';
}

Turn turnFor(Clock::time_point arrived, double deadlineSeconds,
             std::optional<std::chrono::milliseconds> limit) {
    using Seconds = std::chrono::duration<double>;
    Seconds whole(deadlineSeconds);
    if (limit) whole = std::min(whole, Seconds(*limit));
    const Seconds waited = Clock::now() - arrived;
    return {.patience = std::max(whole - waited, Seconds(0.0)),
            // A client that sets a limit knows how long it waits.
            .compilePatience = limit ? Seconds(0.0) : Seconds(kCompilePatience)};
}

FrameService::Drawn FrameService::draw(const Resolved& resolved, Turn turn, Readback readback,
                                       const std::string& requestId) {
    const FrameRequest& request = resolved.request;
    turn.kind = kindOf(request);
    const auto entered = Clock::now();
    const auto abandoned = [&queue = components_.queue, cancellation = turn.cancellation,
                            ends = turn.endsInProgress] {
        using Ends = Turn::EndsInProgress;
        if (queue.isOverdue()) return true;
        if (!cancellation || ends == Ends::never || !cancellation->cancelled()) return false;
        return ends == Ends::always || queue.hasWaiting();
    };
    const auto work = [request, entered, readback, abandoned](Renderer& renderer) {
        const double queueMs = millisecondsSince(entered);
        Frame frame = renderer.render(request, readback, abandoned);
        return Drawn{.frame = std::move(frame),
                     .queueMs = queueMs,
                     .drawMs = millisecondsSince(entered) - queueMs};
    };
    Drawn drawn;
    try {
        drawn = components_.queue.run(turn, work);
    } catch (const FrameAbandoned&) {
        throw RequestError(clientLeft());
    }
    const Frame& frame = drawn.frame;
    components_.canary.frameWasDrawn();
    if (frame.compileMs > kLoggedCompileMs) {
        logInfo({"request ", requestId, ": compiling ", std::to_string(frame.compiled),
                 " shader variants took ", fixedPoint(frame.compileMs, 0), " ms of its frame"});
    }
    components_.library.recordMapBytes(request.scene, frame.mapBytes);
    if (frame.lightNow) components_.library.recordLight(request.scene, frame.lightNow);
    const auto drawnAt = Clock::now();
    drawn.bytes = encoded(frame, request.output);
    drawn.encodeMs = millisecondsSince(drawnAt);
    components_.metrics.frame(frame, 1e-3 * millisecondsSince(entered), 1e-3 * drawn.queueMs,
                              1e-3 * drawn.encodeMs);
    // A curve does not know the time of examining targets, of reading maps back, and of filters.
    if (resolved.pick && readback == Readback::picture && request.filters.empty()) {
        components_.budgets.drawn(*resolved.pick, drawn.drawMs - frame.compileMs);
    }
    return drawn;
}

LightProgress FrameService::lightOf(const FrameRequest& request, Turn turn) {
    turn.kind = kPlanKind;
    const LightState light = components_.queue.run(
        turn, [request](Renderer& renderer) { return renderer.light(request); });
    return {.revision = light.revision,
            .share = light.wanted ? light.share : 1.0,
            .failed = !light.failure.empty()};
}

std::chrono::milliseconds FrameService::waitForLight(const FrameRequest& request, Turn turn,
                                                     std::chrono::milliseconds limit) {
    const auto began = Clock::now();
    const auto cancellation = turn.cancellation;
    turn.kind = kPlanKind;
    const LightState light = components_.queue.run(
        turn, [request](Renderer& renderer) { return renderer.light(request); });
    if (light.wait && !light.complete) {
        light.wait([&] {
            return Clock::now() - began >= limit || (cancellation && cancellation->cancelled());
        });
    }
    return std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - began);
}

FramePlan FrameService::plan(const FrameRequest& request, Turn turn) {
    turn.kind = kPlanKind;
    return components_.queue.run(turn,
                                 [request](Renderer& renderer) { return renderer.plan(request); });
}

}  // namespace clerestory
