#include "server/live/live_stream.h"

#include "server/base/log.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <thread>
#include <utility>

namespace clerestory {
namespace {

using namespace std::chrono_literals;

// Without a new request for this time, a picture is refined.
constexpr auto kRestDelay = 160ms;
// Browsers show a part when the next one begins, so the last frame is sent a second time.
constexpr auto kRepeatDelay = 150ms;
// A still view whose light of surfaces is not complete is drawn again at this interval.
constexpr auto kLightInterval = 1s;
// A still view is sent again at this interval: proxies close idle connections, and only writing
// shows that the client has closed its side.
constexpr auto kStillInterval = 5s;
// How soon a stream sees that the server stops.
constexpr auto kStopPollInterval = 200ms;

constexpr const char* kDelimiter = "--frame\r\n";

}  // namespace

LiveStream::LiveStream(FrameSource& frames, std::shared_ptr<void> slot, StreamRequest request,
                       std::string requestId, std::string client)
    : frames_(frames),
      slot_(std::move(slot)),
      request_(std::move(request)),
      requestId_(std::move(requestId)),
      client_(std::move(client)),
      drawing_(LiveDrawing::of(*request_.view, {.targetMs = request_.targetMs,
                                                .playRate = request_.play ? request_.rate : 0.0})) {
}

LiveDrawing::Draw LiveStream::drawer() {
    return [this](const LiveDrawing::Order& order) {
        EncodedFrame drawn = frames_.draw({.request = order.request,
                                           .requestId = requestId_,
                                           .client = client_,
                                           .cancellation = order.cancellation,
                                           .endsInProgress = order.isRefinement});
        return LiveDrawing::Drawn{std::move(drawn.bytes), drawn.milliseconds, drawn.lightShare};
    };
}

void LiveStream::draw() {
    begun_ = Clock::now();
    std::optional<double> time;
    if (request_.play) {
        // Whole steps of one clock, so that all streams of this rate show the same frames.
        const double now = std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
        time = std::fmod(std::floor(now * request_.rate) / request_.rate, 1e5);
    }
    picture_ = drawing_->moved(picture_, time, drawer());
    version_ = picture_->version;
    cannotRefine_ = false;
}

// Keeps the last picture if the view cannot be drawn.
void LiveStream::drawOrKeep() {
    try {
        draw();
    } catch (const RequestError&) {
        version_ = request_.view->shown().version;
    }
}

bool LiveStream::mayRefine() const {
    return picture_->level > 0 && picture_->version == version_ && !request_.play && !cannotRefine_;
}

// Returns whether there is a new picture.
bool LiveStream::refine() {
    try {
        const auto finer = drawing_->refined(picture_, drawer());
        if (finer) picture_ = finer;
        return finer != nullptr;
    } catch (const RequestError&) {
        cannotRefine_ = true;
        return false;
    }
}

bool LiveStream::mayRelight() const {
    return !mayRefine() && picture_->lightShare < 1.0 && picture_->version == version_ &&
           !request_.play;
}

// Returns whether there is a new picture. The next attempt follows after another interval.
bool LiveStream::relight() {
    lit_ = Clock::now();
    try {
        const auto lit = drawing_->relit(picture_, drawer());
        const bool differs = lit && *lit->bytes != *picture_->bytes;
        if (lit) picture_ = lit;
        return differs;
    } catch (const RequestError&) {
        return false;
    }
}

bool LiveStream::run(const Sink& sink) {
    const auto interval = std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double>(1.0 / request_.rate));
    bool open = send(sink);
    while (open && !frames_.stopping()) {
        // The rate of a paced stream is that of the beginnings of its frames.
        const auto next = (request_.targetMs > 0.0 ? begun_ : sent_) + interval;
        std::this_thread::sleep_until(std::min(next, Clock::now() + kStopPollInterval));
        if (Clock::now() < next) continue;
        const auto again = sent_ + (repeated_ ? Clock::duration(kStillInterval) : kRepeatDelay);
        const auto rest =
            mayRefine() ? request_.view->shown().since + kRestDelay : Clock::time_point::max();
        const auto light = mayRelight() ? std::max(sent_, lit_) + Clock::duration(kLightInterval)
                                        : Clock::time_point::max();
        if (!request_.play) {
            request_.view->waitForNewer(
                version_, std::min({again, rest, light, Clock::now() + kStopPollInterval}));
        }
        if (request_.play || request_.view->shown().version > version_) {
            repeated_ = false;
            drawOrKeep();
            open = send(sink);
        } else if (Clock::now() >= rest) {
            repeated_ = false;
            if (refine()) open = send(sink);
        } else if (Clock::now() >= light) {
            if (relight()) {
                repeated_ = false;
                open = send(sink);
            }
        } else if (Clock::now() >= again) {
            repeated_ = true;
            open = send(sink);
        }
    }
    return false;
}

bool LiveStream::send(const Sink& sink) {
    const LivePicture& picture = *picture_;
    std::string text = delimiterSent_ ? "" : kDelimiter;
    text += "Content-Type: image/jpeg\r\nContent-Length: " + std::to_string(picture.bytes->size()) +
            "\r\nClerestory-View-Version: " + std::to_string(picture.version) + "\r\n";
    if (request_.targetMs > 0.0) {
        text += "Clerestory-Level: " + std::to_string(picture.level) +
                "\r\nClerestory-Size: " + std::to_string(picture.width) + 'x' +
                std::to_string(picture.height) +
                "\r\nClerestory-Preset: " + (picture.settings.draft ? "draft" : "requested") +
                "\r\nServer-Timing: frame;dur=" + fixedPoint(picture.milliseconds, 3) + "\r\n";
    }
    text += "\r\n" + *picture.bytes + "\r\n";
    // The delimiter ends the part, so that a client can show it before the next one begins.
    delimiterSent_ = request_.targetMs > 0.0;
    if (delimiterSent_) text += kDelimiter;
    sent_ = Clock::now();
    return sink(text);
}

}  // namespace clerestory
