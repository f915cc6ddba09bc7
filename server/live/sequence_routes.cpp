// POST /v1/sequences: many frames in one answer, sent as they are drawn.
#include "server/api/frames.h"
#include "server/base/log.h"
#include "server/live/archive.h"
#include "server/live/film_request.h"
#include "server/live/live_routes.h"
#include "server/live/sequence_files.h"

#include <deque>
#include <future>

namespace clerestory {
namespace {

// The files of one frame, or the problem why it could not be drawn.
struct Outcome {
    FrameFiles made;
    std::optional<Problem> problem;
};

// What an answer is made of. Both return false if nothing more can be sent.
class Content {
public:
    virtual ~Content() = default;
    virtual bool add(std::size_t index, const Outcome& outcome) = 0;
    virtual bool end() = 0;
};

// Files, and a manifest that lists the frames that could not be drawn.
class FilesContent final : public Content {
public:
    FilesContent(std::unique_ptr<Archive> archive, const std::string& requestId)
        : archive_(std::move(archive)), requestId_(requestId) {}

    bool add(std::size_t index, const Outcome& outcome) override {
        if (outcome.problem) {
            manifest_.addFailure(index, problemDocument(*outcome.problem, requestId_));
            return true;
        }
        for (const SequenceFile& file : outcome.made.files) {
            if (!archive_->add(file.name, file.type, file.bytes)) return false;
        }
        manifest_.add(outcome.made.record);
        return true;
    }
    bool end() override {
        const SequenceFile file = manifest_.file();
        return archive_->add(file.name, file.type, file.bytes) && archive_->end();
    }

private:
    const std::unique_ptr<Archive> archive_;
    const std::string requestId_;
    Manifest manifest_;
};

// A film has no place for an error: a frame that cannot be drawn truncates the answer.
class FilmContent final : public Content {
public:
    explicit FilmContent(std::unique_ptr<Film> film) : film_(std::move(film)) {}

    bool add(std::size_t index, const Outcome& outcome) override {
        if (!outcome.problem) return film_->add(outcome.made.files.front().bytes);
        throw std::runtime_error("frame " + std::to_string(index) +
                                 " of a film: " + outcome.problem->detail);
    }
    bool end() override { return film_->end(); }

private:
    const std::unique_ptr<Film> film_;
};

// One answer. It outlives the call, because the stream runs after the head of the answer.
struct Run {
    FrameSource& source;
    Sequence sequence;
    std::string requestId, client;
    bool multipart = false;
    std::optional<FilmSettings> film;
    std::shared_ptr<CancellationToken> cancellation;
    std::shared_ptr<void> slot;

    const char* type() const {
        if (film) return mediaType(film->format);
        return multipart ? kMultipartType : kTarType;
    }

    std::unique_ptr<Content> content(const Sink& sink) const {
        if (film) return std::make_unique<FilmContent>(makeFilm(*film, sink));
        return std::make_unique<FilesContent>(multipart ? multipartArchive(sink) : tarArchive(sink),
                                              requestId);
    }

    // A film may have nothing to send for a while, and so no other way to notice.
    bool clientLeft() const { return cancellation && cancellation->cancelled(); }

    Outcome frame(std::size_t index) const {
        try {
            return {.made = filesOf(sequence, index, [&](const FrameRequest& request) {
                        return source.draw(request, true, requestId, client);
                    })};
        } catch (const RequestError& error) {
            return {.problem = error.problem()};
        }
    }

    // Draws the next frames while one is sent: as many as there are renderers, so that they keep
    // no other client waiting. Returns true if everything was sent.
    bool send(Content& content, Outcome outcome) const {
        std::deque<std::future<Outcome>> ahead;
        for (std::size_t i = sequence.first;; ++i) {
            for (std::size_t next = i + 1 + ahead.size();
                 next < sequence.end && ahead.size() < source.renderers(); ++next) {
                ahead.push_back(
                    std::async(std::launch::async, [this, next] { return frame(next); }));
            }
            if (!content.add(i, outcome)) return false;
            if (ahead.empty()) break;
            outcome = ahead.front().get();
            ahead.pop_front();
            if (source.stopping() || clientLeft()) return false;
        }
        return content.end();
    }
};

bool acceptsMultipart(const Call& call) {
    return call.header("Accept").find("multipart/mixed") != std::string::npos;
}

}  // namespace

Answer postSequence(const LiveRoutes& routes, const Call& call) {
    requireJsonType(call);
    requireQuery(call, false);
    auto run = std::make_shared<Run>(Run{.source = routes.frames,
                                         .requestId = call.requestId,
                                         .client = call.client,
                                         .multipart = acceptsMultipart(call),
                                         .cancellation = call.cancellation,
                                         .slot = routes.slots.take(call.client)});
    run->sequence = sequenceFrom(strictJson(call.body));
    if (const auto format = filmFormatIn(call.header("Accept"))) {
        run->film = makeFilmSequence(run->sequence, *format);
    }
    // Most errors of the first frame are errors of every frame, and can still have a status.
    auto first = std::make_shared<Outcome>(run->frame(run->sequence.first));
    if (first->problem) return firstFrameRefused(*first->problem, call);
    Answer answer{.type = run->type()};
    answer.headers = {{"Cache-Control", "no-store"}};
    answer.stream = [run, first](const Sink& sink) {
        try {
            return run->send(*run->content(sink), std::move(*first));
        } catch (const std::exception& error) {
            logError({"request ", run->requestId, ": a sequence ended early: ", error.what()});
            return false;
        }
    };
    return answer;
}

}  // namespace clerestory
