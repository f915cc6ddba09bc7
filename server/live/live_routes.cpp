#include "server/live/live_routes.h"

#include "server/api/frame_json.h"
#include "server/api/frames.h"
#include "server/base/log.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <thread>

namespace clerestory {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;

constexpr double kDefaultRate = 15.0, kMaxRate = 60.0;
// Browsers show a part when the next one begins, so the last frame is sent a second time.
constexpr auto kRepeatDelay = 150ms;
// A still view is sent again at this interval: proxies close idle connections, and only writing
// shows that the client has closed its side.
constexpr auto kStillInterval = 5s;
// How soon a stream sees that the server stops.
constexpr auto kStopPollInterval = 200ms;

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

struct StreamRequest {
    std::shared_ptr<LiveView> view;
    double rate = kDefaultRate;  // the most frames per second
    bool play = false;           // the time of the frames is the clock's
};

StreamRequest streamRequestFrom(const LiveViews& views, const Call& call) {
    auto query = call.query;
    StreamRequest stream;
    std::vector<FieldError> errors;
    if (const auto text = take(query, "fps")) {
        const auto [end, error] =
            std::from_chars(text->data(), text->data() + text->size(), stream.rate);
        const bool whole = error == std::errc() && end == text->data() + text->size();
        if (!whole || !(stream.rate >= 0.1) || !(stream.rate <= kMaxRate)) {
            errors.push_back({"/fps", "is out of range", "a number from 0.1 to 60"});
        }
    }
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

class Stream {
public:
    Stream(FrameSource& frames, std::shared_ptr<void> slot, StreamRequest request,
           std::string requestId)
        : frames_(frames),
          slot_(std::move(slot)),
          request_(std::move(request)),
          requestId_(std::move(requestId)) {}

    // Draws the present frame. Throws RequestError.
    void draw() {
        const LiveView::Shown shown = request_.view->shown();
        FrameRequest frame = shown.request;
        if (request_.play) {
            // Whole steps of one clock, so that all streams of this rate show the same frames.
            const double now =
                std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
            frame.time = std::fmod(std::floor(now * request_.rate) / request_.rate, 1e5);
        }
        picture_ = request_.view->picture(
            canonicalText(frame), [&] { return frames_.draw(frame, false, requestId_).bytes; });
        version_ = shown.version;
    }

    // Sends pictures until the server stops or the client closes its side.
    bool run(const Sink& sink) {
        const auto interval = std::chrono::duration_cast<Clock::duration>(
            std::chrono::duration<double>(1.0 / request_.rate));
        bool open = send(sink);
        while (open && !frames_.stopping()) {
            std::this_thread::sleep_until(
                std::min(sent_ + interval, Clock::now() + kStopPollInterval));
            if (Clock::now() < sent_ + interval) continue;
            const auto again = sent_ + (repeated_ ? Clock::duration(kStillInterval) : kRepeatDelay);
            if (!request_.play) {
                request_.view->waitForNewer(version_,
                                            std::min(again, Clock::now() + kStopPollInterval));
            }
            if (request_.play || request_.view->shown().version > version_) {
                repeated_ = false;
                drawOrKeep();
                open = send(sink);
            } else if (Clock::now() >= again) {
                repeated_ = true;
                open = send(sink);
            }
        }
        return false;
    }

private:
    // Keeps the last picture if the view cannot be drawn.
    void drawOrKeep() {
        try {
            draw();
        } catch (const RequestError&) {
            version_ = request_.view->shown().version;
        }
    }

    bool send(const Sink& sink) {
        const std::string head = "--frame\r\nContent-Type: image/jpeg\r\nContent-Length: " +
                                 std::to_string(picture_->size()) + "\r\n\r\n";
        sent_ = Clock::now();
        return sink(head + *picture_ + "\r\n");
    }

    FrameSource& frames_;
    std::shared_ptr<void> slot_;
    StreamRequest request_;
    std::string requestId_;
    LiveView::Picture picture_;
    std::uint64_t version_ = 0;
    bool repeated_ = false;  // the last frame was sent a second time
    Clock::time_point sent_;
};

Answer putView(const LiveRoutes& routes, const Call& call) {
    const std::string name = nameIn(call);
    requireJsonType(call);
    requireQuery(call, false);
    const json body = strictJson(call.body);
    FrameRequest request = jpegRequestFrom(body);
    routes.views.make(name)->put(std::move(request), body.dump());
    return {.status = 204};
}

Answer getView(const LiveRoutes& routes, const Call& call) {
    requireQuery(call, false);
    return {.type = "application/json",
            .body = viewNamed(routes.views, nameIn(call))->shown().text,
            .headers = {{"Cache-Control", "no-store"}}};
}

Answer getStream(const LiveRoutes& routes, const Call& call) {
    StreamRequest request = streamRequestFrom(routes.views, call);
    const auto stream = std::make_shared<Stream>(routes.frames, routes.slots.take(),
                                                 std::move(request), call.requestId);
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
