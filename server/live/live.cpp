#include "server/live/live.h"

#include "server/api/frame_json.h"
#include "server/api/frames.h"
#include "server/base/log.h"
#include "server/live/inner_call.h"
#include "server/live/live_views.h"
#include "server/server.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace clerestory {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;

constexpr double kDefaultRate = 15.0, kMaxRate = 60.0;
// Browsers show a part when the next begins, so the last frame is sent once more.
constexpr auto kSettled = 150ms;
// Again now and then: a connection that carries nothing is taken for dead, and only writing tells
// that the client has left.
constexpr auto kStill = 5s;
// How long a stop waits for a stream that shows a still view.
constexpr auto kLiveLooksUp = 200ms;

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

// Motion JPEG holds JPEG pictures of colour.
void requireJpeg(const json& body) {
    const Output output = frameRequestFrom(body).output;
    if (output.format == OutputFormat::jpeg && output.channel == Channel::color) return;
    throw RequestError(invalidFields({{"/output", "is not a JPEG of colour", "format jpeg"}}));
}

std::shared_ptr<LiveView> viewNamed(Server& server, const std::string& name) {
    auto view = server.views().find(name);
    if (!view) {
        throw RequestError(
            notFound("There is no live view of this name; PUT /v1/views/NAME makes one."));
    }
    return view;
}

// Takes `name` out of the query.
std::optional<std::string> taken(std::multimap<std::string, std::string>& query, const char* name) {
    const auto found = query.find(name);
    if (found == query.end()) return std::nullopt;
    const std::string value = found->second;
    query.erase(name);
    return value;
}

struct Wish {
    std::shared_ptr<LiveView> view;
    double rate = kDefaultRate;  // most frames a second
    bool play = false;           // the request's time runs
};

Wish wishFrom(Server& server, const Call& call) {
    auto query = call.query;
    Wish wish;
    std::vector<FieldError> errors;
    if (const auto text = taken(query, "fps")) {
        const auto [end, error] =
            std::from_chars(text->data(), text->data() + text->size(), wish.rate);
        const bool whole = error == std::errc() && end == text->data() + text->size();
        if (!whole || !(wish.rate >= 0.1) || !(wish.rate <= kMaxRate)) {
            errors.push_back({"/fps", "is out of range", "a number from 0.1 to 60"});
        }
    }
    if (const auto text = taken(query, "play")) {
        wish.play = *text == "1";
        if (*text != "0" && *text != "1") errors.push_back({"/play", "is not 0 or 1", "0 or 1"});
    }
    const auto name = taken(query, "view");
    if (name && !query.empty()) {
        errors.push_back({"/view", "conflicts with the fields of a frame", "one of the two"});
    }
    if (!errors.empty()) throw RequestError(invalidFields(std::move(errors)));
    if (name) {
        wish.view = viewNamed(server, *name);
    } else {
        json body = bodyFromQuery(query);
        requireJpeg(body);
        wish.view = std::make_shared<LiveView>();
        wish.view->put(std::move(body));
    }
    return wish;
}

class Stream {
public:
    Stream(Server& server, Wish wish, std::string requestId)
        : server_(server),
          slot_(server.streams().take()),
          wish_(std::move(wish)),
          requestId_(std::move(requestId)) {}

    // The frame that is to be seen now.
    void draw() {
        const LiveView::Shown shown = wish_.view->shown();
        json body = shown.body;
        if (wish_.play) {
            // Whole steps of one clock, so that all who watch at this rate see the same frames.
            const double now =
                std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
            body["time"] = std::fmod(std::floor(now * wish_.rate) / wish_.rate, 1e5);
        }
        const std::string text = body.dump();
        picture_ =
            wish_.view->picture(text, [&] { return plainFrame(server_, text, requestId_).body; });
        version_ = shown.version;
    }

    bool send(const Sink& sink) {
        const std::string head = "--frame\r\nContent-Type: image/jpeg\r\nContent-Length: " +
                                 std::to_string(picture_->size()) + "\r\n\r\n";
        sent_ = Clock::now();
        return sink(head + *picture_ + "\r\n");
    }

    // Until the service stops, or the client leaves.
    bool run(const Sink& sink) {
        const auto interval = std::chrono::duration_cast<Clock::duration>(
            std::chrono::duration<double>(1.0 / wish_.rate));
        bool there = send(sink);
        while (there && !server_.stopping()) {
            std::this_thread::sleep_until(std::min(sent_ + interval, Clock::now() + kLiveLooksUp));
            if (Clock::now() < sent_ + interval) continue;
            const auto again = sent_ + (settled_ ? Clock::duration(kStill) : kSettled);
            if (!wish_.play) {
                wish_.view->waitForNewer(version_, std::min(again, Clock::now() + kLiveLooksUp));
            }
            if (wish_.play || wish_.view->shown().version > version_) {
                settled_ = false;
                drawOrKeep();
                there = send(sink);
            } else if (Clock::now() >= again) {
                settled_ = true;
                there = send(sink);
            }
        }
        return false;
    }

private:
    // A view that cannot be drawn leaves the picture as it was.
    void drawOrKeep() {
        try {
            draw();
        } catch (const InnerFailure&) {
            version_ = wish_.view->shown().version;
        }
    }

    Server& server_;
    std::shared_ptr<void> slot_;
    Wish wish_;
    std::string requestId_;
    LiveView::Picture picture_;
    std::uint64_t version_ = 0;
    bool settled_ = false;  // the last frame was sent once more
    Clock::time_point sent_;
};

}  // namespace

Answer putView(Server& server, const Call& call) {
    const std::string name = nameIn(call);
    requireJsonType(call);
    requireQuery(call, false);
    json body = strictJson(call.body);
    requireJpeg(body);
    server.views().make(name)->put(std::move(body));
    return {.status = 204};
}

Answer getView(Server& server, const Call& call) {
    requireQuery(call, false);
    return {.type = "application/json",
            .body = viewNamed(server, nameIn(call))->shown().body.dump(),
            .headers = {{"Cache-Control", "no-store"}}};
}

Answer getStream(Server& server, const Call& call) {
    auto stream = std::make_shared<Stream>(server, wishFrom(server, call), call.requestId);
    try {
        stream->draw();  // what is wrong with it still has a status
    } catch (const InnerFailure& failure) {
        return failure.answer();
    }
    return {.type = "multipart/x-mixed-replace; boundary=frame",
            .headers = {{"Cache-Control", "no-store"}},
            .stream = [stream](const Sink& sink) {
                try {
                    return stream->run(sink);
                } catch (const std::exception& error) {
                    logError({"a live stream broke off: ", error.what()});
                    return false;
                }
            }};
}

}  // namespace clerestory
