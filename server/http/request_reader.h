// Parses the bytes of a connection into complete requests within the limits. The request line and
// the headers are parsed strictly: everything that RFC 9112 lets a server reject is rejected, which
// prevents request smuggling.
//
// Does not: know sockets or clocks.
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
    std::string target;     // not decoded: a path from "/" on with its query, or "*"
    std::string authority;  // of a target in absolute form; also the value of the header Host
    int minorVersion = 1;   // of HTTP/1.x
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

// The head as bytes, with the target as a path and without Range: ranges are not supported, so that
// the header is ignored whatever it says (RFC 9110 14.2).
std::string headText(const RequestHead& head);

// The maximum size of the body in bytes.
std::size_t bodyLimit(const RequestHead& head, const HttpLimits& limits);

// Whether a method or header name may contain the byte (RFC 9110 5.6.2).
bool isTokenByte(unsigned char c);

class RequestReader {
public:
    enum class State { idle, head, body, complete, refused };

    // The limits must outlive it.
    explicit RequestReader(const HttpLimits& limits) : limits_(&limits) {}
    explicit RequestReader(const HttpLimits&&) = delete;

    // Maximum number of bytes for the next take(); 0 if the request is complete or refused.
    std::size_t room() const;
    void take(std::string_view bytes);

    State state() const { return state_; }
    const Problem& problem() const { return *problem_; }  // when refused
    // From State::body on; if refused, as far as it was parsed.
    const RequestHead& head() const { return head_; }
    std::string_view headBytes() const;  // up to the blank line, inclusive
    std::string_view body() const;       // when complete, until it is taken
    std::string takeBody();              // when complete; once
    std::size_t bodyBytes() const;       // of the body, received so far

    // Continues with the bytes after the complete request.
    void next();

private:
    void advance();
    void skipBlankLines();
    bool foundHead();
    void refuse(Problem problem);

    const HttpLimits* limits_;
    State state_ = State::idle;
    std::string bytes_;
    std::size_t scanned_ = 0;    // bytes of bytes_ that were searched for the end of the headers
    std::size_t lineBegin_ = 0;  // of the incomplete line
    std::size_t lines_ = 0;      // complete ones
    std::size_t headEnd_ = 0;
    std::string behind_;  // bytes after a body that was taken
    bool taken_ = false;
    std::size_t blanks_ = 0;  // blank lines before the request
    RequestHead head_;
    std::optional<Problem> problem_;
};

}  // namespace clerestory
