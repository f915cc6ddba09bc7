// Bytes as they come from a client -> whole requests, never more than the limits allow of them.
//
// Does not: know sockets or clocks.
#pragma once

#include "server/http/request_head.h"

namespace clerestory {

class RequestReader {
public:
    enum class State { idle, head, body, complete, refused };

    // The limits must outlive it.
    explicit RequestReader(const FrontLimits& limits) : limits_(&limits) {}
    explicit RequestReader(const FrontLimits&&) = delete;

    // How many bytes take() may be given now; 0 when the request is complete or refused.
    std::size_t room() const;
    void take(std::string_view bytes);

    State state() const { return state_; }
    const Problem& problem() const { return *problem_; }  // when refused
    // From State::body on; when refused, what had been understood.
    const RequestHead& head() const { return head_; }
    std::string_view headBytes() const;  // with the blank line
    std::string_view body() const;       // when complete, until it is taken
    std::string takeBody();              // when complete; once
    std::size_t bodyBytes() const;       // of the body, that have come

    // Forgets the complete request, and goes on with what came behind it.
    void next();

private:
    void advance();
    void skipBlankLines();
    bool foundHead();
    void refuse(Problem problem);

    const FrontLimits* limits_;
    State state_ = State::idle;
    std::string bytes_;
    std::size_t scanned_ = 0;    // of bytes_, without the end of the head
    std::size_t lineBegin_ = 0;  // of the line that is coming
    std::size_t lines_ = 0;      // that are whole
    std::size_t headEnd_ = 0;
    std::string behind_;  // what came after the body, when that was taken
    bool taken_ = false;
    std::size_t blanks_ = 0;  // lines skipped before the request
    RequestHead head_;
    std::optional<Problem> problem_;
};

}  // namespace clerestory
