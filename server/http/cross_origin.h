// Cross-origin requests (CORS, as in the Fetch standard): pages of allowed origins may read answers
// and send JSON. Credentials are not shared: a page sends a token itself.
#pragma once

#include "server/base/call.h"

#include <optional>
#include <string>
#include <vector>

namespace clerestory {

class CrossOrigin {
public:
    // SCHEME://HOST[:PORT] as browsers send it; "*" allows any; none: no page of another origin.
    explicit CrossOrigin(std::vector<std::string> origins) : origins_(std::move(origins)) {}

    // The answer to a browser's question whether it may send a request; empty for other calls and
    // for origins that are not allowed. It precedes the request, so that it carries no token.
    std::optional<Answer> preflight(const Call& call) const;

    // Adds the headers with which the page that sent the call may read the answer.
    Answer permitted(const Call& call, Answer answer) const;

private:
    bool allows(const std::string& origin) const;
    void permit(const std::string& origin, Answer& answer) const;

    const std::vector<std::string> origins_;
};

}  // namespace clerestory
