#include "server/http/request_reader.h"

namespace clerestory {
namespace {

// Some clients send an extra CRLF after a body (RFC 9112 2.2).
constexpr std::size_t kBlankLines = 4;

}  // namespace

std::size_t RequestReader::room() const {
    switch (state_) {
        case State::idle:
        case State::head:
            return limits_->headBytes + 1 - bytes_.size();
        case State::body:
            return headEnd_ + head_.contentLength - bytes_.size();
        case State::complete:
        case State::refused:
            break;
    }
    return 0;
}

void RequestReader::take(std::string_view bytes) {
    bytes_ += bytes;
    advance();
}

std::string_view RequestReader::headBytes() const {
    return std::string_view(bytes_).substr(0, headEnd_);
}

std::string_view RequestReader::body() const {
    return std::string_view(bytes_).substr(headEnd_, head_.contentLength);
}

std::size_t RequestReader::bodyBytes() const {
    return state_ == State::body ? bytes_.size() - headEnd_ : 0;
}

// Moves a large body instead of copying it.
std::string RequestReader::takeBody() {
    behind_ = bytes_.substr(headEnd_ + head_.contentLength);
    taken_ = true;
    std::string body = std::move(bytes_);
    bytes_.assign(body, 0, headEnd_);
    body.resize(headEnd_ + head_.contentLength);
    body.erase(0, headEnd_);
    return body;
}

void RequestReader::next() {
    std::string rest = taken_ ? std::move(behind_) : bytes_.substr(headEnd_ + head_.contentLength);
    *this = RequestReader(*limits_);  // frees the memory of a large request
    bytes_ = std::move(rest);
    advance();
}

void RequestReader::refuse(Problem problem) {
    problem_ = std::move(problem);
    state_ = State::refused;
    bytes_ = std::string();
}

void RequestReader::skipBlankLines() {
    while (bytes_.starts_with("\r\n")) {
        bytes_.erase(0, 2);
        if (++blanks_ > kBlankLines) return refuse(notHttp());
    }
}

// Examines each byte once, in order: the cost does not grow with the number of pieces, and the
// result does not depend on how the bytes are divided.
bool RequestReader::foundHead() {
    for (; scanned_ < bytes_.size(); ++scanned_) {
        if (lines_ == 0 && scanned_ >= limits_->requestLine + 2) {
            return refuse(uriTooLong(limits_->path, limits_->requestLine)), false;
        }
        if (scanned_ >= limits_->headBytes) {
            return refuse(headTooLarge(limits_->headBytes, limits_->headers)), false;
        }
        if (bytes_[scanned_] != '\n') continue;
        // Servers disagree on whether a bare LF ends a line, which allows request smuggling.
        if (scanned_ == lineBegin_ || bytes_[scanned_ - 1] != '\r') return refuse(notHttp()), false;
        if (scanned_ - lineBegin_ == 1) {
            headEnd_ = scanned_ + 1;
            return true;
        }
        if (++lines_ > limits_->headers + 1) {
            return refuse(headTooLarge(limits_->headBytes, limits_->headers)), false;
        }
        lineBegin_ = scanned_ + 1;
    }
    return false;
}

void RequestReader::advance() {
    if (state_ == State::idle || state_ == State::head) {
        if (scanned_ == 0) skipBlankLines();
        if (state_ == State::refused) return;
        state_ = bytes_.empty() ? State::idle : State::head;
        if (bytes_.empty() || bytes_ == "\r") return;
        // Other protocols are recognised by their first byte.
        if (!isTokenByte(static_cast<unsigned char>(bytes_.front()))) return refuse(notHttp());
        if (!foundHead()) return;
        HeadOutcome outcome = readHead(headBytes(), *limits_);
        head_ = std::move(outcome.head);
        if (outcome.problem) return refuse(*std::move(outcome.problem));
        state_ = State::body;
        bytes_.reserve(headEnd_ + head_.contentLength);  // avoids reallocation
    }
    if (state_ == State::body && bytes_.size() >= headEnd_ + head_.contentLength) {
        state_ = State::complete;
    }
}

}  // namespace clerestory
