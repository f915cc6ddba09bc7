// Parses the bytes of a connection into complete requests within the limits.
//
// Does not: know sockets or clocks.
#pragma once

#include "server/http/request_head.h"

namespace clerestory {

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
