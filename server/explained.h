// The answer to explain=1: a picture and what was done for it, as two parts of one message.
#pragma once

#include "server/call.h"

namespace clerestory {

struct ExplainedFrame {
    std::string type, picture;  // media type and bytes
    std::string plan;           // JSON
};

// Sets the answer's type and body. No picture holds `boundary`: it hashes the request.
void putExplained(Answer& answer, const ExplainedFrame& frame, const std::string& boundary);

// Of an answer that putExplained() made. Throws std::runtime_error for any other.
ExplainedFrame explainedIn(const Answer& answer);

}  // namespace clerestory
