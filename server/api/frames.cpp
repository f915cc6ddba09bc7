#include "server/api/frames.h"

#include "measures/displayed.h"
#include "plan/graph/work.h"
#include "server/api/compact_passes.h"
#include "server/api/encode_answer.h"
#include "server/api/explained.h"
#include "server/api/frame_json.h"
#include "server/base/build_id.h"
#include "server/base/content_hash.h"
#include "server/base/log.h"
#include "server/service.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>

namespace clerestory {
namespace {

struct Drawn {
    Frame frame;
    double queueMs = 0.0;
    double drawMs = 0.0;
};

FrameRequest requestFrom(const nlohmann::json& body, const Call& call) {
    FrameRequest defaults;
    defaults.output.format = formatFor(call.header("Accept"));
    return frameRequestFrom(body, defaults);
}

// Of every environment map that some surface reflects by name.
std::string mapsByName(Service& service, const Scene& scene, const FrameRequest& request) {
    std::string text;
    const auto add = [&](const std::string& map) {
        if (!map.empty()) text += std::to_string(service.library().environmentHash(map)) + '\n';
    };
    for (const Material& m : scene.materials) add(m.environmentMap);
    for (const MaterialOverride& o : request.overrides) add(o.environmentMap.value_or(""));
    return text;
}

std::string etagOf(Service& service, const Scene& scene, const FrameRequest& request) {
    return '"' + hashWordOf(contentText(service, scene, request)) + '"';
}

constexpr std::uint64_t kPlanKind = 1;
constexpr double kLoggedCompileMs = 100.0;
// Beyond its deadline a frame waits for so long while shaders are compiled.
constexpr std::chrono::seconds kCompilePatience{60};

// Frames of one kind differ in what they look at, and so take about the same time.
std::uint64_t kindOf(FrameRequest request) {
    request.camera = {};
    request.time = 0.0;
    request.output = {};
    return hashOf(canonicalText(request));
}

// If-None-Match compares weakly (RFC 9110 13.1.2), so that W/"x" names "x" too.
bool matches(const std::string& ifNoneMatch, const std::string& etag) {
    return ifNoneMatch == "*" || ifNoneMatch.find(etag) != std::string::npos;
}

std::string serverTiming(const Drawn& drawn, double encodeMs, double totalMs) {
    std::vector<std::pair<std::string, double>> entries = {{"queue", drawn.queueMs},
                                                           {"plan", drawn.frame.planMs}};
    const std::size_t firstPass = entries.size();
    for (const PassTime& time : drawn.frame.passTimes) {
        const auto same =
            std::find_if(entries.begin() + static_cast<std::ptrdiff_t>(firstPass), entries.end(),
                         [&](const auto& e) { return e.first == time.kind; });
        if (same == entries.end()) {
            entries.emplace_back(time.kind, time.milliseconds);
        } else {
            same->second += time.milliseconds;
        }
    }
    entries.emplace_back("readback", drawn.frame.readbackMs);
    if (drawn.frame.compiled > 0) entries.emplace_back("compile", drawn.frame.compileMs);
    entries.emplace_back("encode", encodeMs);
    entries.emplace_back("total", totalMs);
    std::string header;
    for (const auto& [name, milliseconds] : entries) {
        char text[96];
        std::snprintf(text, sizeof text, "%s%.40s;dur=%.3f", header.empty() ? "" : ", ",
                      name.c_str(), milliseconds);
        header += text;
    }
    return header;
}

// As the frame would show it: by its exposure and its curve.
std::string mapJpeg(const Image& radiance, const FrameRequest& request) {
    const auto factor = static_cast<float>(std::exp2(request.exposure));
    const Image shown = quantised(displayed(radiance, request.toneMap, factor));
    return encodeJpeg(shown, static_cast<int>(request.output.quality), false);
}

// The picture, then the plan with its milliseconds, and its health or its maps where those were
// asked for.
void addExplanation(Answer& answer, const Frame& frame, const FrameRequest& request,
                    const std::string& etag) {
    nlohmann::ordered_json json = planJson(frame.plan, frame.passTimes);
    if (!frame.health.empty()) json["health"] = healthJson(frame.health);
    ExplainedFrame explained{
        .type = answer.type,
        .picture = std::move(answer.body),
        .plan = json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)};
    for (const FrameMap& map : frame.maps) {
        explained.maps.push_back({map.target, mapJpeg(map.picture, request)});
    }
    putExplained(answer, explained, "clerestory-" + etag.substr(1, etag.size() - 2));
}

enum class Explain { no, plan, health, maps };
Explain explains(const Call& call) {
    const auto found = call.query.find("explain");
    if (found == call.query.end() || found->second == "0") return Explain::no;
    if (found->second == "1") return Explain::plan;
    if (found->second == "health") return Explain::health;
    if (found->second == "maps") return Explain::maps;
    throw RequestError(
        invalidFields({{"/explain", "is not a known word", "0, 1, health or maps"}}));
}

Readback readbackFor(Explain explain) {
    switch (explain) {
        case Explain::health:
            return Readback::health;
        case Explain::maps:
            return Readback::maps;
        case Explain::no:
        case Explain::plan:
            break;
    }
    return Readback::picture;
}

// A budget gives way to the knobs that it comes to; everything else stays as it was asked.
std::optional<Budgets::Pick> picked(Service& service, const Scene& scene, FrameRequest& request) {
    if (!request.accuracy.isBudget()) return std::nullopt;
    Budgets::Pick pick = service.budgets().pick(service, scene, request);
    request.accuracy = pick.accuracy;
    return pick;
}

Answer frame(Service& service, const Call& call, FrameRequest request) {
    const Explain asked = explains(call);
    const bool explain = asked != Explain::no;
    const auto scene = service.library().require(request.scene);
    request.scene = scene->id;
    const auto pick = picked(service, *scene, request);
    requireAffordable(request, service.config().renderer.mostSamples);
    const std::string etag = etagOf(service, *scene, request);
    Answer answer;
    answer.headers = {{"Cache-Control", "no-cache"}, {"Vary", "Accept"}};
    // An explanation's milliseconds never come twice.
    if (!explain) answer.headers.emplace_back("ETag", etag);
    if (call.method == "GET" && !explain && matches(call.header("If-None-Match"), etag)) {
        service.metrics().notModified();
        answer.status = 304;
        return answer;
    }
    const auto door = Clock::now();
    const Turn turn = turnOf(service, call, kindOf(request));
    const Drawn drawn = service.queue().run(turn, [request, door, asked](Renderer& renderer) {
        const double queueMs = millisecondsSince(door);
        Frame frame = renderer.render(request, readbackFor(asked));
        return Drawn{std::move(frame), queueMs, millisecondsSince(door) - queueMs};
    });
    service.frameWasDrawn();
    if (drawn.frame.compileMs > kLoggedCompileMs) {
        logInfo({"request ", call.requestId, ": compiling ", std::to_string(drawn.frame.compiled),
                 " shader variants took ", fixedPoint(drawn.frame.compileMs, 0),
                 " ms of its frame"});
    }
    service.library().mapsTook(request.scene, drawn.frame.mapBytes);
    const auto drawnAt = Clock::now();
    answer.body = encoded(drawn.frame.image, request.output);
    answer.type = mediaType(request.output.format);
    const double encodeMs = millisecondsSince(drawnAt);
    service.metrics().frame(drawn.frame, 1e-3 * millisecondsSince(door), 1e-3 * drawn.queueMs,
                            1e-3 * encodeMs);
    answer.headers.emplace_back("Server-Timing",
                                serverTiming(drawn, encodeMs, millisecondsSince(call.arrived)));
    answer.headers.emplace_back("Clerestory-Passes", compactPasses(drawn.frame.plan));
    answer.headers.emplace_back("Clerestory-Scene-Generation",
                                std::to_string(drawn.frame.sceneGeneration));
    if (pick) {
        answer.headers.emplace_back("Clerestory-Accuracy", pick->words);
        // Examining every target takes longer than the frame, and so do taking maps away and
        // filters, which no curve knows.
        const bool plain = asked == Explain::no || asked == Explain::plan;
        if (plain && request.filters.empty()) {
            service.budgets().drawn(service, *pick, drawn.drawMs - drawn.frame.compileMs);
        }
    }
    if (explain) addExplanation(answer, drawn.frame, request, etag);
    return answer;
}

}  // namespace

std::string contentText(Service& service, const Scene& scene, const FrameRequest& request) {
    const RendererIdentity& id = service.queue().identity();
    const std::string map = request.environment.map.value_or(scene.environment);
    return canonicalText(request) + '\n' + std::to_string(scene.contentHash) + '\n' +
           std::to_string(service.library().environmentHash(map)) + '\n' +
           mapsByName(service, scene, request) + buildId() + '\n' + id.vendor + '\n' + id.renderer +
           '\n' + id.version + '\n' + id.platform;
}

Turn turnOf(Service& service, const Call& call, std::uint64_t kind) {
    std::chrono::duration<double> whole(service.config().deadlineSeconds);
    std::chrono::duration<double> compilePatience = kCompilePatience;
    if (const std::string text = call.header("Clerestory-Deadline"); !text.empty()) {
        unsigned milliseconds = 0;
        const auto [end, error] =
            std::from_chars(text.data(), text.data() + text.size(), milliseconds);
        if (error != std::errc() || end != text.data() + text.size() || milliseconds == 0) {
            throw RequestError(badRequest("Clerestory-Deadline is not a number of milliseconds."));
        }
        whole = std::min(whole, std::chrono::duration<double>(0.001 * milliseconds));
        compilePatience = {};  // the client knows how long it waits
    }
    const std::chrono::duration<double> waited = Clock::now() - call.arrived;
    return {.client = call.client,
            .kind = kind,
            .patience = std::max(whole - waited, std::chrono::duration<double>(0.0)),
            .cancellation = call.cancellation,
            .compilePatience = compilePatience};
}

void requireJsonType(const Call& call) {
    std::string type = call.header("Content-Type");
    type = type.substr(0, type.find(';'));
    while (!type.empty() && type.back() == ' ') type.pop_back();
    std::transform(type.begin(), type.end(), type.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (type != "application/json") throw RequestError(notJsonType());
}

// A POST's query holds nothing but `explain`.
void requireQuery(const Call& call, bool explainAllowed) {
    for (const auto& [name, value] : call.query) {
        if (explainAllowed && name == "explain") continue;
        throw RequestError(invalidFields({{"/" + name.substr(0, 64),
                                           "is not a known query name; a POST has its fields in "
                                           "the body",
                                           explainAllowed ? "explain" : "nothing"}}));
    }
}

Answer postFrame(Service& service, const Call& call) {
    requireJsonType(call);
    requireQuery(call, true);
    return frame(service, call, requestFrom(strictJson(call.body), call));
}

Answer getFrame(Service& service, const Call& call) {
    auto query = call.query;
    query.erase("explain");
    if (!service.config().http.access.linkKeyFile.empty()) {  // a link's seal, checked at the door
        query.erase("expires");
        query.erase("signature");
    }
    return frame(service, call, requestFrom(bodyFromQuery(query), call));
}

Answer postPlan(Service& service, const Call& call) {
    requireJsonType(call);
    requireQuery(call, false);
    FrameRequest request = requestFrom(strictJson(call.body), call);
    const auto scene = service.library().require(request.scene);
    request.scene = scene->id;
    const auto pick = picked(service, *scene, request);
    const FramePlan plan =
        service.queue().run(turnOf(service, call, kPlanKind),
                            [request](Renderer& renderer) { return renderer.plan(request); });
    nlohmann::ordered_json json = planJson(plan);
    if (pick) json["accuracy"] = {{"chosen", accuracyJson(pick->accuracy)}, {"words", pick->words}};
    return {.type = "application/json",
            .body = json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)};
}

}  // namespace clerestory
