// The first lines of a request, read strictly: what RFC 9112 lets a server refuse is refused, so
// that nobody further on can understand them in another way.
#pragma once

#include "server/base/problem.h"
#include "server/http/limits.h"

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace clerestory {

struct RequestHead {
    std::string method;
    std::string target;    // as it came: a path from "/" on with its query, or "*"
    int minorVersion = 1;  // of HTTP/1.x
    std::vector<std::pair<std::string, std::string>> headers;
    std::size_t contentLength = 0;
    bool keepAlive = true;
    bool expectsContinue = false;

    // The first of that name in any case; empty when absent.
    std::string_view header(std::string_view name) const;
    std::string_view path() const;  // as it came, without the query
};

struct HeadOutcome {
    RequestHead head;                // as far as it was understood
    std::optional<Problem> problem;  // 400, 411, 413, 414, 415, 417, 431, 501, 505
};

// `text`: every line with its CRLF, up to the blank one.
HeadOutcome readHead(std::string_view text, const FrontLimits& limits);

// The bytes that a body may have there.
std::size_t bodyLimit(const RequestHead& head, const FrontLimits& limits);

// Of a method's or header's name (RFC 9110 5.6.2).
bool isTokenByte(unsigned char c);

}  // namespace clerestory
