#include "server/live/live_routes.h"

#include "server/api/frame_json.h"
#include "server/api/frames.h"
#include "server/base/log.h"
#include "server/live/live_stream.h"

#include "scene/fields.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <optional>

namespace clerestory {
namespace {

using nlohmann::json;

constexpr double kDefaultRate = 15.0, kMinRate = 0.1, kMaxRate = 60.0;
constexpr double kMinTargetMs = 10.0, kMaxTargetMs = 5000.0;

std::string nameIn(const Call& call) {
    const std::string name = call.path.substr(call.path.rfind('/') + 1);
    const bool plain =
        name.size() <= 64 && std::all_of(name.begin(), name.end(), [](unsigned char c) {
            return std::isalnum(c) || c == '-' || c == '_';
        });
    if (plain) return name;
    throw RequestError(
        invalidFields({{"/name", "is not a view's name", "up to 64 letters, digits, - and _"}}));
}

// The request of a view. Motion JPEG consists of JPEG pictures in colour.
FrameRequest jpegRequestFrom(const json& body) {
    FrameRequest request = frameRequestFrom(body);
    const Output& output = request.output;
    if (output.format == OutputFormat::jpeg && output.channel == Channel::color) return request;
    throw RequestError(invalidFields({{"/output", "is not a JPEG of colour", "format jpeg"}}));
}

std::shared_ptr<LiveView> viewNamed(const LiveViews& views, const std::string& name) {
    auto view = views.find(name);
    if (!view) {
        throw RequestError(
            notFound("There is no live view of this name; PUT /v1/views/NAME makes one."));
    }
    return view;
}

// Removes `name` from the query and returns its value.
std::optional<std::string> take(std::multimap<std::string, std::string>& query, const char* name) {
    const auto found = query.find(name);
    if (found == query.end()) return std::nullopt;
    const std::string value = found->second;
    query.erase(name);
    return value;
}

// A number of the query. Adds an error if it is not one in [min, max].
std::optional<double> takeNumber(std::multimap<std::string, std::string>& query, const char* name,
                                 double min, double max, std::vector<FieldError>& errors) {
    const auto text = take(query, name);
    if (!text) return std::nullopt;
    double value = 0.0;
    const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), value);
    const bool whole = error == std::errc() && end == text->data() + text->size();
    if (whole && value >= min && value <= max) return value;
    errors.push_back({std::string("/") + name, "is out of range",
                      "a number from " + field::numberText(min) + " to " + field::numberText(max)});
    return std::nullopt;
}

StreamRequest streamRequestFrom(const LiveViews& views, const Call& call) {
    auto query = call.query;
    StreamRequest stream;
    std::vector<FieldError> errors;
    const auto target = takeNumber(query, "targetMs", kMinTargetMs, kMaxTargetMs, errors);
    stream.targetMs = target.value_or(0.0);
    stream.rate = takeNumber(query, "fps", kMinRate, kMaxRate, errors)
                      .value_or(target ? kMaxRate : kDefaultRate);
    if (const auto text = take(query, "play")) {
        stream.play = *text == "1";
        if (*text != "0" && *text != "1") errors.push_back({"/play", "is not 0 or 1", "0 or 1"});
    }
    const auto name = take(query, "view");
    if (name && !query.empty()) {
        errors.push_back({"/view", "conflicts with the fields of a frame", "one of the two"});
    }
    if (!errors.empty()) throw RequestError(invalidFields(std::move(errors)));
    if (name) {
        stream.view = viewNamed(views, *name);
    } else {
        stream.view = std::make_shared<LiveView>();
        const json body = bodyFromQuery(query);
        stream.view->put(jpegRequestFrom(body), body.dump());
    }
    return stream;
}

Answer putView(const LiveRoutes& routes, const Call& call) {
    const std::string name = nameIn(call);
    requireJsonType(call);
    requireQuery(call, false);
    const json body = strictJson(call.body);
    FrameRequest request = jpegRequestFrom(body);
    const std::uint64_t version =
        routes.views.make(name, call.client)->put(std::move(request), body.dump());
    return {.status = 204, .headers = {{"Clerestory-View-Version", std::to_string(version)}}};
}

Answer getView(const LiveRoutes& routes, const Call& call) {
    requireQuery(call, false);
    return {.type = "application/json",
            .body = viewNamed(routes.views, nameIn(call))->shown().text,
            .headers = {{"Cache-Control", "no-store"}}};
}

Answer getStream(const LiveRoutes& routes, const Call& call) {
    StreamRequest request = streamRequestFrom(routes.views, call);
    const auto stream =
        std::make_shared<LiveStream>(routes.frames, routes.slots.take(call.client),
                                     std::move(request), call.requestId, call.client);
    try {
        stream->draw();  // before the status is sent, so that a problem has one
    } catch (const RequestError& error) {
        return firstFrameRefused(error.problem(), call);
    }
    return {.type = "multipart/x-mixed-replace; boundary=frame",
            .headers = {{"Cache-Control", "no-store"}},
            .stream = [stream](const Sink& sink) {
                try {
                    return stream->run(sink);
                } catch (const std::exception& error) {
                    logError({"a live stream ended early: ", error.what()});
                    return false;
                }
            }};
}

}  // namespace

Answer firstFrameRefused(const Problem& problem, const Call& call) {
    Answer answer = problemAnswer(problem, call.requestId);
    answer.problem.reset();
    return answer;
}

void addRoutes(Routes& routes, const LiveRoutes& components) {
    routes.add("/v1/sequences", "POST", components, postSequence);
    routes.add("/v1/views/{name}", "PUT", components, putView);
    routes.add("/v1/views/{name}", "GET", components, getView);
    routes.add("/v1/stream", "GET", components, getStream);
}

}  // namespace clerestory
