// Frames that the server asks of itself, for sequences and live streams: the request takes the way
// of any client's, and waits where a patient client would try again.
#pragma once

#include "server/api/explained.h"

#include <stdexcept>

namespace clerestory {

class Server;

// The frame was refused for good.
class InnerFailure : public std::runtime_error {
public:
    explicit InnerFailure(std::string problem)
        : std::runtime_error("a frame was refused"), problem_(std::move(problem)) {}
    const std::string& problem() const { return problem_; }  // the problem document
    Answer answer() const;                                   // the same to a client

private:
    std::string problem_;
};

// Both take the body of a POST /v1/frames; at a full queue, or while the scene loads, they try
// again for a while. Throw InnerFailure; also when the service stops.
ExplainedFrame explainedFrame(Server& server, const std::string& body,
                              const std::string& requestId);
Answer plainFrame(Server& server, const std::string& body, const std::string& requestId);

}  // namespace clerestory
