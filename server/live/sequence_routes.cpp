// POST /v1/sequences: many frames in one answer, sent as they are drawn.
#include "server/api/frames.h"
#include "server/base/log.h"
#include "server/live/archive.h"
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

// One answer. It outlives the call, because the stream runs after the head of the answer.
struct Run {
    FrameSource& source;
    Sequence sequence;
    std::string requestId, client;
    bool multipart = false;
    std::shared_ptr<void> slot;

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
    bool send(Archive& archive, Outcome outcome) const {
        Manifest manifest;
        std::deque<std::future<Outcome>> ahead;
        for (std::size_t i = sequence.first;; ++i) {
            for (std::size_t next = i + 1 + ahead.size();
                 next < sequence.end && ahead.size() < source.renderers(); ++next) {
                ahead.push_back(
                    std::async(std::launch::async, [this, next] { return frame(next); }));
            }
            if (outcome.problem) {
                manifest.addFailure(i, problemDocument(*outcome.problem, requestId));
            } else {
                for (const SequenceFile& file : outcome.made.files) {
                    if (!archive.add(file.name, file.type, file.bytes)) return false;
                }
                manifest.add(outcome.made.record);
            }
            if (ahead.empty()) break;
            outcome = ahead.front().get();
            ahead.pop_front();
            if (source.stopping()) return false;
        }
        const SequenceFile file = manifest.file();
        return archive.add(file.name, file.type, file.bytes) && archive.end();
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
                                         .slot = routes.slots.take(call.client)});
    run->sequence = sequenceFrom(strictJson(call.body));
    // Most errors of the first frame are errors of every frame, and can still have a status.
    auto first = std::make_shared<Outcome>(run->frame(run->sequence.first));
    if (first->problem) return firstFrameRefused(*first->problem, call);
    Answer answer{.type = run->multipart ? kMultipartType : kTarType};
    answer.headers = {{"Cache-Control", "no-store"}};
    answer.stream = [run, first](const Sink& sink) {
        const auto archive = run->multipart ? multipartArchive(sink) : tarArchive(sink);
        try {
            return run->send(*archive, std::move(*first));
        } catch (const std::exception& error) {
            logError({"request ", run->requestId, ": a sequence ended early: ", error.what()});
            return false;
        }
    };
    return answer;
}

}  // namespace clerestory
