#include "server/api/frames.h"

#include "measures/errors.h"
#include "server/api/compact_passes.h"
#include "server/api/encode_answer.h"
#include "server/api/explained.h"
#include "server/api/frame_json.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>

namespace clerestory {
namespace {

FrameRequest requestFrom(const nlohmann::json& body, const Call& call,
                         std::vector<FieldError> errors) {
    FrameRequest defaults;
    defaults.output.format = formatFor(call.header("Accept"));
    return frameRequestFrom(body, defaults, std::move(errors));
}

std::string serverTiming(const FrameService::Drawn& drawn, double totalMs) {
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
    entries.emplace_back("encode", drawn.encodeMs);
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

// With the exposure and the tone mapping of the frame.
std::string mapJpeg(const Image& radiance, const FrameRequest& request) {
    const auto factor = static_cast<float>(std::exp2(request.exposure));
    const Image shown = quantised(displayed(radiance, request.toneMap, factor));
    return encodeJpeg(shown, static_cast<int>(request.output.quality), false);
}

// The picture, then the plan with the time of each pass, and health or maps if requested.
void addExplanation(Answer& answer, const Frame& frame, const FrameRequest& request,
                    const std::string& etag) {
    nlohmann::ordered_json json = planJson(frame.plan, frame.passTimes);
    if (!frame.health.empty()) json["health"] = healthJson(frame.health);
    if (!frame.maps.empty()) json["maps"] = mapsJson(frame.plan, frame.maps);
    ExplainedFrame explained{
        .type = answer.type, .picture = std::move(answer.body), .plan = jsonText(json)};
    for (const MapPicture& map : frame.maps) {
        explained.maps.push_back({map.target, mapJpeg(map.picture, request)});
    }
    putExplained(answer, explained, "clerestory-" + etag.substr(1, etag.size() - 2));
}

Explain explainOf(const Call& call, std::vector<FieldError>& errors) {
    const auto found = call.query.find("explain");
    if (found == call.query.end() || found->second == "0") return Explain::no;
    if (found->second == "1") return Explain::plan;
    if (found->second == "health") return Explain::health;
    if (found->second == "maps") return Explain::maps;
    errors.push_back({"/explain", "is not a known word", "0, 1, health or maps"});
    return Explain::no;
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

// Longest time that a client can wait for the light of surfaces.
constexpr unsigned kMaxLightWait = 60;  // seconds

// Prefer: wait=N (RFC 7240): seconds; 0 without it.
unsigned preferredWait(const Call& call) {
    const std::string text = call.header("Prefer");
    const std::string name = "wait=";
    const std::size_t at = text.find(name);
    if (at == std::string::npos) return 0;
    unsigned seconds = 0;
    const char* first = text.data() + at + name.size();
    const auto [end, error] = std::from_chars(first, text.data() + text.size(), seconds);
    if (error == std::errc::result_out_of_range) return kMaxLightWait;
    return error == std::errc() && end != first ? std::min(seconds, kMaxLightWait) : 0;
}

std::string lightHeader(const LightProgress& light) {
    char text[64];
    std::snprintf(text, sizeof text, "revision=%u, share=%.2f%s", light.revision, light.share,
                  light.failed ? ", failed" : "");
    return text;
}

// A GET that a page of another site made, as for an image. Browsers write this header, pages
// cannot.
bool isForeign(const Call& call) {
    const std::string site = call.header("Sec-Fetch-Site");
    return call.method == "GET" && !site.empty() && site != "same-origin" && site != "none";
}

Answer frame(const FrameRoutes& routes, const Call& call) {
    FrameCall given = frameCallFrom(call, routes.signedLinks);
    const Explain explain = given.explain;
    const bool explained = explain != Explain::no;
    FrameService& frames = routes.frames;
    const FrameService::Resolved resolved = frames.resolve(
        std::move(given.request), {call.client, !isForeign(call)}, turnOf(frames, call).patience);
    const FrameRequest& request = resolved.request;
    frames.requireAffordable(request);
    const bool light = FrameService::showsLight(request);
    std::string etag = frames.etagOf(resolved);
    Answer answer;
    answer.headers = {{"Cache-Control", "no-cache"}, {"Vary", "Accept"}};
    Turn turn = turnOf(frames, call);
    if (const unsigned seconds = light ? preferredWait(call) : 0; seconds > 0) {
        frames.waitForLight(request, turn, std::chrono::seconds(seconds));
        answer.headers.emplace_back("Preference-Applied", "wait=" + std::to_string(seconds));
    }
    const std::string ifNoneMatch = call.header("If-None-Match");
    if (call.method == "GET" && !explained && !ifNoneMatch.empty()) {
        const LightProgress shown = light ? frames.lightOf(request, turn) : LightProgress{};
        etag = frames.etagOf(resolved, shown.revision);
        if (matchesEntityTag(ifNoneMatch, etag)) {
            if (light) answer.headers.emplace_back("Clerestory-Light", lightHeader(shown));
            answer.headers.emplace_back("ETag", etag);
            frames.countNotModified();
            answer.status = 304;
            return answer;
        }
    }
    FrameService::Drawn drawn =
        frames.draw(resolved, std::move(turn), readbackFor(explain), call.requestId);
    if (light) {
        etag = frames.etagOf(resolved, drawn.frame.light.revision);
        answer.headers.emplace_back("Clerestory-Light", lightHeader(drawn.frame.light));
    }
    // The times of an explanation differ each time.
    if (!explained) answer.headers.emplace_back("ETag", etag);
    answer.body = std::move(drawn.bytes);
    answer.type = mediaType(request.output.format);
    answer.sceneHash = resolved.scene->contentHash;
    answer.headers.emplace_back("Server-Timing",
                                serverTiming(drawn, millisecondsSince(call.arrived)));
    answer.headers.emplace_back("Clerestory-Passes", compactPasses(drawn.frame.plan));
    answer.headers.emplace_back("Clerestory-Scene-Generation",
                                std::to_string(drawn.frame.sceneGeneration));
    if (resolved.pick) answer.headers.emplace_back("Clerestory-Accuracy", resolved.pick->words);
    if (explained) addExplanation(answer, drawn.frame, request, etag);
    return answer;
}

Answer postPlan(const FrameRoutes& routes, const Call& call) {
    const FrameService::Resolved resolved = routes.frames.resolve(
        frameCallFrom(call, false).request, {call.client}, turnOf(routes.frames, call).patience);
    const FramePlan plan = routes.frames.plan(resolved.request, turnOf(routes.frames, call));
    nlohmann::ordered_json json = planJson(plan);
    if (resolved.pick) {
        json["accuracy"] = {{"chosen", accuracyJson(resolved.pick->accuracy)},
                            {"words", resolved.pick->words}};
    }
    return {.type = "application/json", .body = jsonText(json)};
}

}  // namespace

void addRoutes(Routes& routes, const FrameRoutes& components) {
    routes.add("/v1/frames", "POST", components, frame);
    routes.add("/v1/frames", "GET", components, frame);
    routes.add("/v1/plans", "POST", components, postPlan);
}

FrameCall frameCallFrom(const Call& call, bool signedLinks) {
    std::vector<FieldError> errors;
    const Explain explain = explainOf(call, errors);
    if (call.method == "POST") {
        requireJsonType(call);
        requireQuery(call, call.path == "/v1/frames");
        return {requestFrom(strictJson(call.body), call, std::move(errors)), explain};
    }
    auto query = call.query;
    query.erase("explain");
    if (signedLinks) {
        query.erase("expires");
        query.erase("signature");
    }
    const nlohmann::json body = bodyFromQuery(query, errors);
    return {requestFrom(body, call, std::move(errors)), explain};
}

// The header compares weakly (RFC 9110 13.1.2), so that W/"x" names "x" too.
bool matchesEntityTag(const std::string& ifNoneMatch, const std::string& etag) {
    return ifNoneMatch == "*" || ifNoneMatch.find(etag) != std::string::npos;
}

std::optional<std::chrono::milliseconds> deadlineIn(const Call& call) {
    const std::string text = call.header("Clerestory-Deadline");
    if (text.empty()) return std::nullopt;
    unsigned milliseconds = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), milliseconds);
    if (error != std::errc() || end != text.data() + text.size() || milliseconds == 0) {
        throw RequestError(badRequest("Clerestory-Deadline is not a number of milliseconds."));
    }
    return std::chrono::milliseconds(milliseconds);
}

Turn turnOf(const FrameService& frames, const Call& call) {
    Turn turn = frames.turnFor(call.arrived, deadlineIn(call));
    turn.client = call.client;
    turn.cancellation = call.cancellation;
    return turn;
}

void requireJsonType(const Call& call) {
    std::string type = call.header("Content-Type");
    type = type.substr(0, type.find(';'));
    while (!type.empty() && type.back() == ' ') type.pop_back();
    std::transform(type.begin(), type.end(), type.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (type != "application/json") throw RequestError(notJsonType());
}

void requireQuery(const Call& call, bool explainAllowed) {
    for (const auto& [name, value] : call.query) {
        if (explainAllowed && name == "explain") continue;
        throw RequestError(invalidFields({{"/" + name.substr(0, 64),
                                           "is not a known query name; a POST has its fields in "
                                           "the body",
                                           explainAllowed ? "explain" : "nothing"}}));
    }
}

}  // namespace clerestory
