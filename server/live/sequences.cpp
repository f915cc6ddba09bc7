#include "server/live/sequences.h"

#include "server/api/explained.h"
#include "server/api/frames.h"
#include "server/base/log.h"
#include "server/live/archive.h"
#include "server/live/inner_call.h"
#include "server/live/sequence_files.h"
#include "server/server.h"

#include <future>

namespace clerestory {
namespace {

using nlohmann::json;

// What one frame came to: its files, or the problem document that says why not.
struct Outcome {
    std::vector<SequenceFile> files;
    std::optional<InnerFailure> failure;
};

// Outlives the route: the stream runs when its answer is already on the way.
struct Run {
    Server& server;
    Sequence sequence;
    std::string requestId;
    bool multipart = false;
    std::shared_ptr<void> slot;  // one of the streams that may run at once

    Outcome frame(std::size_t index) const {
        try {
            return {.files = filesOf(sequence, index, [&](const json& body) {
                        const ExplainedFrame frame = explainedFrame(server, body.dump(), requestId);
                        return MadeFrame{frame.picture, frame.type,
                                         nlohmann::ordered_json::parse(frame.plan)};
                    })};
        } catch (const InnerFailure& failure) {
            return {.failure = failure};
        }
    }

    // While one frame is sent the next is drawn. True when all was sent.
    bool send(Archive& archive, Outcome outcome) const {
        Manifest manifest;
        for (std::size_t i = sequence.first;; ++i) {
            std::future<Outcome> next;
            if (i + 1 < sequence.count()) {
                next = std::async(std::launch::async, [this, i] { return frame(i + 1); });
            }
            if (outcome.failure) {
                manifest.addFailure(i, json::parse(outcome.failure->problem()));
            } else {
                for (const SequenceFile& file : outcome.files) {
                    if (!archive.add(file.name, file.type, file.bytes)) return false;
                }
                manifest.add(outcome.files.back());
            }
            if (!next.valid()) break;
            outcome = next.get();
            if (server.stopping()) return false;
        }
        const SequenceFile file = manifest.file();
        return archive.add(file.name, file.type, file.bytes) && archive.end();
    }
};

bool wantsMultipart(const Call& call) {
    return call.header("Accept").find("multipart/mixed") != std::string::npos;
}

}  // namespace

Answer postSequence(Server& server, const Call& call) {
    requireJsonType(call);
    requireQuery(call, false);
    auto run = std::make_shared<Run>(Run{.server = server,
                                         .requestId = call.requestId,
                                         .multipart = wantsMultipart(call),
                                         .slot = server.streams().take()});
    run->sequence = sequenceFrom(strictJson(call.body));
    // What is wrong with the first frame is mostly wrong with all: it still has a status.
    auto first = std::make_shared<Outcome>(run->frame(run->sequence.first));
    if (first->failure) return first->failure->answer();
    Answer answer{.type = run->multipart ? kMultipartType : kTarType};
    answer.headers = {{"Cache-Control", "no-store"}};
    answer.stream = [run, first](const Sink& sink) {
        const auto archive = run->multipart ? multipartArchive(sink) : tarArchive(sink);
        try {
            return run->send(*archive, std::move(*first));
        } catch (const std::exception& error) {
            logError({"request ", run->requestId, ": a sequence broke off: ", error.what()});
            return false;
        }
    };
    return answer;
}

}  // namespace clerestory
