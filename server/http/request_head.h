// The request line and headers, parsed strictly: everything that RFC 9112 lets a server reject is
// rejected, which prevents request smuggling.
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
    std::string target;    // not decoded: a path from "/" on with its query, or "*"
    int minorVersion = 1;  // of HTTP/1.x
    std::vector<std::pair<std::string, std::string>> headers;
    std::size_t contentLength = 0;
    bool keepAlive = true;
    bool expectsContinue = false;

    // The first header of that name, ignoring case; empty if absent.
    std::string_view header(std::string_view name) const;
    std::string_view path() const;  // not decoded
};

struct HeadOutcome {
    RequestHead head;                // as far as it could be parsed
    std::optional<Problem> problem;  // 400, 411, 413, 414, 415, 417, 431, 501, 505
};

// `text`: all lines with their CRLF, up to the blank line.
HeadOutcome readHead(std::string_view text, const HttpLimits& limits);

// The maximum size of the body in bytes.
std::size_t bodyLimit(const RequestHead& head, const HttpLimits& limits);

// Whether a method or header name may contain the byte (RFC 9110 5.6.2).
bool isTokenByte(unsigned char c);

}  // namespace clerestory
