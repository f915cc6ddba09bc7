// The answer to explain: a picture, its plan, and with explain=maps the maps that its mirrors read,
// as parts of one message.
#pragma once

#include "server/base/call.h"

#include <vector>

namespace clerestory {

struct ExplainedFrame {
    std::string type, picture;  // media type and bytes
    std::string plan;           // JSON
    struct Map {
        std::string target;  // its name in the plan
        std::string jpeg;
    };
    std::vector<Map> maps = {};
};

// Sets the answer's type and body. No picture holds `boundary`: it hashes the request.
void putExplained(Answer& answer, const ExplainedFrame& frame, const std::string& boundary);

}  // namespace clerestory
