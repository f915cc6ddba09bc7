#include "server/http/exchange.h"

#include "server/http/limits.h"

#include <linux/sockios.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <random>

namespace clerestory {
namespace {

constexpr std::pair<const char*, const char*> kCommonHeaders[] = {
    {"X-Content-Type-Options", "nosniff"},
    {"Content-Security-Policy",
     "default-src 'self'; img-src 'self' blob: data:; frame-ancestors 'none'"},
    {"Referrer-Policy", "no-referrer"}};

const char* reasonOf(int status) {
    switch (status) {
        case 200:
            return "OK";
        case 400:
            return "Bad Request";
        case 401:
            return "Unauthorized";
        case 403:
            return "Forbidden";
        case 408:
            return "Request Timeout";
        case 411:
            return "Length Required";
        case 413:
            return "Payload Too Large";
        case 414:
            return "URI Too Long";
        case 415:
            return "Unsupported Media Type";
        case 417:
            return "Expectation Failed";
        case 421:
            return "Misdirected Request";
        case 431:
            return "Request Header Fields Too Large";
        case 501:
            return "Not Implemented";
        case 503:
            return "Service Unavailable";
        case 505:
            return "HTTP Version Not Supported";
        default:
            return status < 400 ? "OK" : "Error";
    }
}

// Bytes that a stream may be ahead of its reader, in addition to the socket's buffer.
constexpr std::size_t kAhead = 256 * 1024;

// A client that may not have another small response of this size is refused before the work.
constexpr std::size_t kLeastResponse = 512 * 1024;

Pool poolOf(std::size_t bytes) {
    return bytes <= kSmallBytes ? Pool::smallResponseBytes : Pool::responseBytes;
}

}  // namespace

Call callOf(const Exchange& exchange) {
    const RequestHead& head = exchange.head;
    return {.method = head.method == "HEAD" ? "GET" : head.method,
            .path = std::string(head.path()),
            .target = head.target,
            .requestId = exchange.requestId,
            .arrived = exchange.arrived,
            .header = [&head](const char* name) { return std::string(head.header(name)); },
            .client = exchange.client,
            .cancellation = exchange.cancellation};
}

std::span<const std::pair<const char*, const char*>> commonHeaders() {
    return kCommonHeaders;
}

std::string responseBytes(const Answer& answer, const std::string& requestId, bool keepAlive,
                          bool isHead) {
    std::string text = "HTTP/1.1 " + std::to_string(answer.status) + " " + reasonOf(answer.status);
    const auto add = [&](std::string_view name, std::string_view value) {
        text.append("\r\n").append(name).append(": ").append(value);
    };
    for (const auto& [name, value] : commonHeaders()) add(name, value);
    for (const auto& [name, value] : answer.headers) add(name, value);
    add("X-Request-Id", requestId);
    if (!answer.type.empty()) add("Content-Type", answer.type);
    if (answer.status != 204 && answer.status != 304) {
        add("Content-Length", std::to_string(answer.body.size()));
    }
    add("Connection", keepAlive ? "keep-alive" : "close");
    text += "\r\n\r\n";
    if (!isHead) text += answer.body;
    return text;
}

std::string requestIdFrom(std::string_view given) {
    const bool plain = !given.empty() && given.size() <= 64 &&
                       std::all_of(given.begin(), given.end(), [](unsigned char c) {
                           return std::isalnum(c) || c == '-' || c == '_' || c == '.';
                       });
    if (plain) return std::string(given);
    static const std::uint32_t start = std::random_device{}();
    static std::atomic<std::uint32_t> count{0};
    char text[32];
    std::snprintf(text, sizeof text, "%08x-%06x", start, count.fetch_add(1));
    return text;
}

SocketWriter::SocketWriter(int socket, Holdings& holdings, std::string client,
                           std::function<void()> wake)
    : socket_(socket),
      holdings_(holdings),
      wake_(std::move(wake)),
      client_(std::move(client)),
      held_(holdings.take(Pool::responseBytes, client_, 0)) {}

SocketWriter::~SocketWriter() {
    held_.reset();
    share_.reset();
    close(socket_);
}

void SocketWriter::setClient(const std::string& client) {
    const std::lock_guard lock(mutex_);
    if (client == client_) return;
    client_ = client;
    held_.reset();
    held_ = holdings_.take(Pool::responseBytes, client_, 0);
}

bool SocketWriter::mayRequest() const {
    const std::lock_guard lock(mutex_);
    return holdings_.of(Pool::smallResponseBytes, client_) == 0 ||
           holdings_.allows(Pool::smallResponseBytes, client_, kLeastResponse);
}

bool SocketWriter::reserve(std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    share_.reset();
    if (bytes <= kUncountedBytes) return true;
    share_ = holdings_.take(poolOf(bytes), client_, bytes);
    return share_.has_value();
}

bool SocketWriter::sendBody(std::shared_ptr<const std::string> body) {
    const std::lock_guard lock(mutex_);
    body_ = std::move(body);
    bodyBegin_ = 0;
    flushLocked();
    if (unsent() > 0 && !broken_) wake_();
    return !broken_;
}

std::size_t SocketWriter::bodyBytes() const {
    const std::lock_guard lock(mutex_);
    return body_ ? body_->size() : 0;
}

// A response is taken whole, so that its thread is free; only a stream waits for its reader.
bool SocketWriter::send(std::string_view bytes, bool streamed) {
    std::unique_lock lock(mutex_);
    while (!bytes.empty() && !broken_) {
        const std::string_view piece = streamed ? bytes.substr(0, kAhead) : bytes;
        bytes.remove_prefix(piece.size());
        bytes_ += piece;
        if (unsent() == piece.size()) flushLocked();
        if (streamed) held_->resize(copied());
        if (unsent() == 0 || broken_) continue;
        wake_();
        if (streamed) drained_.wait(lock, [&] { return broken_ || unsent() <= kAhead; });
    }
    return !broken_;
}

void SocketWriter::flush() {
    const std::lock_guard lock(mutex_);
    flushLocked();
}

void SocketWriter::flushLocked() {
    while (!broken_ && unsent() > 0) {
        const std::string_view part = unsentPart();
        const ssize_t n = ::send(socket_, part.data(), part.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0 && (errno == EAGAIN || errno == ENOBUFS)) break;
        if (n <= 0) {
            broken_ = true;
            break;
        }
        advance(static_cast<std::size_t>(n));
    }
    // Frees sent bytes occasionally: each time would move the rest too often.
    if (copied() == 0) {
        bytes_ = std::string();
        begin_ = 0;
    } else if (begin_ > (1 << 20) && begin_ > copied()) {
        bytes_.erase(0, begin_);
        begin_ = 0;
    }
    held_->resize(std::min(held_->amount(), copied()));
    if (broken_ || unsent() <= kAhead) drained_.notify_all();
}

std::string_view SocketWriter::unsentPart() const {
    if (copied() > 0) return std::string_view(bytes_).substr(begin_);
    return std::string_view(*body_).substr(bodyBegin_);
}

void SocketWriter::advance(std::size_t count) {
    sent_ += count;
    (copied() > 0 ? begin_ : bodyBegin_) += count;
    if (!body_ || unsent() > 0) return;  // the headers are sent first
    body_.reset();
    share_.reset();
}

void SocketWriter::abort() {
    const std::lock_guard lock(mutex_);
    broken_ = true;
    drained_.notify_all();
}

bool SocketWriter::pending() const {
    const std::lock_guard lock(mutex_);
    return unsent() > 0 && !broken_;
}

bool SocketWriter::broken() const {
    const std::lock_guard lock(mutex_);
    return broken_;
}

std::uint64_t SocketWriter::deliveredBytes() const {
    const std::lock_guard lock(mutex_);
    int waiting = 0;
    if (ioctl(socket_, SIOCOUTQ, &waiting) != 0) waiting = 0;
    return sent_ - std::min<std::uint64_t>(sent_, static_cast<std::uint64_t>(waiting));
}

}  // namespace clerestory
