#include "server/http/request_reader.h"

#include <algorithm>
#include <cctype>

namespace clerestory {
namespace {

constexpr std::string_view kMethods[] = {"GET",   "HEAD",   "POST",   "PUT",
                                         "PATCH", "DELETE", "OPTIONS"};

bool sameName(std::string_view a, std::string_view b) {
    return a.size() == b.size() &&
           std::equal(a.begin(), a.end(), b.begin(), [](unsigned char x, unsigned char y) {
               return std::tolower(x) == std::tolower(y);
           });
}

bool isToken(std::string_view text) {
    return !text.empty() && std::all_of(text.begin(), text.end(), isTokenByte);
}

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
    while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
    return text;
}

// Whether the comma-separated list contains the word.
bool contains(std::string_view list, std::string_view word) {
    while (!list.empty()) {
        const std::size_t comma = std::min(list.find(','), list.size());
        if (sameName(trimmed(list.substr(0, comma)), word)) return true;
        list.remove_prefix(std::min(comma + 1, list.size()));
    }
    return false;
}

// Percent-encoding is complete, and no byte is invalid in a URI.
bool isTarget(std::string_view text) {
    for (std::size_t i = 0; i < text.size(); ++i) {
        const auto c = static_cast<unsigned char>(text[i]);
        if (c <= ' ' || c == 127 || c == '#') return false;
        if (c != '%') continue;
        if (i + 2 >= text.size() || !std::isxdigit(static_cast<unsigned char>(text[i + 1])) ||
            !std::isxdigit(static_cast<unsigned char>(text[i + 2]))) {
            return false;
        }
    }
    return !text.empty() && text.front() == '/';
}

// Removes the next line from `text` and returns it without its CRLF.
std::string_view nextLine(std::string_view& text) {
    const std::size_t end = std::min(text.find("\r\n"), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 2, text.size()));
    return line;
}

// Of a target in absolute form, as proxies send it, which becomes a path; otherwise empty.
std::string_view takeAuthority(std::string_view& target) {
    for (const std::string_view scheme : {"http://", "https://"}) {
        if (!sameName(target.substr(0, scheme.size()), scheme)) continue;
        const std::size_t end = std::min(target.find_first_of("/?", scheme.size()), target.size());
        const std::string_view authority = target.substr(scheme.size(), end - scheme.size());
        const bool isPlain = std::all_of(authority.begin(), authority.end(), [](unsigned char c) {
            return std::isalnum(c) ||
                   std::string_view("-._:[]").find(static_cast<char>(c)) != std::string_view::npos;
        });
        if (authority.empty() || !isPlain) return {};
        target.remove_prefix(end);
        if (target.empty()) target = "/";
        return authority;
    }
    return {};
}

std::optional<Problem> readRequestLine(std::string_view line, RequestHead& head,
                                       const HttpLimits& limits) {
    const std::size_t first = line.find(' '), last = line.rfind(' ');
    if (first == std::string_view::npos || first == last) return notHttp();
    const std::string_view method = line.substr(0, first), version = line.substr(last + 1);
    std::string_view target = line.substr(first + 1, last - first - 1);
    head.authority = takeAuthority(target);
    if (!isToken(method) || !version.starts_with("HTTP/")) return notHttp();
    head.method = method;
    head.target = target;
    if (version != "HTTP/1.1" && version != "HTTP/1.0") return versionNotSupported();
    head.minorVersion = version.back() - '0';
    if (std::find(std::begin(kMethods), std::end(kMethods), method) == std::end(kMethods)) {
        return notImplemented();
    }
    if (line.size() > limits.requestLine || head.path().size() > limits.path) {
        return uriTooLong(limits.path, limits.requestLine);
    }
    const bool any = method == "OPTIONS" && target == "*";
    if (!any && !isTarget(target)) return badRequest("The target is not a path from / on.");
    return std::nullopt;
}

std::optional<Problem> readHeaderLine(std::string_view line, RequestHead& head) {
    const std::size_t colon = line.find(':');
    // A name is a token up to its colon: no blank before it, and no line that goes on with another.
    if (colon == std::string_view::npos || !isToken(line.substr(0, colon))) {
        return badRequest("A header field is not of the form NAME: VALUE.");
    }
    const std::string_view value = trimmed(line.substr(colon + 1));
    const bool plain = std::none_of(value.begin(), value.end(), [](unsigned char c) {
        return (c < 32 && c != '\t') || c == 127;
    });
    if (!plain) return badRequest("A header field contains a control character.");
    head.headers.emplace_back(line.substr(0, colon), value);
    return std::nullopt;
}

std::size_t countOf(const RequestHead& head, std::string_view name) {
    return static_cast<std::size_t>(
        std::count_if(head.headers.begin(), head.headers.end(),
                      [&](const auto& header) { return sameName(header.first, name); }));
}

// Headers that determine the length of the body; ambiguous ones are rejected.
std::optional<Problem> readBodyHeaders(RequestHead& head, const HttpLimits& limits) {
    const std::size_t lengths = countOf(head, "Content-Length");
    if (countOf(head, "Transfer-Encoding") > 0) {
        if (lengths > 0)
            return badRequest("Content-Length and Transfer-Encoding exclude each other.");
        return lengthRequired();
    }
    if (lengths > 0) {
        const std::string_view text = head.header("Content-Length");
        const bool digits =
            !text.empty() &&
            std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c); });
        if (lengths > 1 || !digits) return badRequest("Content-Length is not a number.");
        const std::size_t maxBytes = bodyLimit(head, limits);
        for (const char digit : text) {
            head.contentLength = 10 * head.contentLength + static_cast<std::size_t>(digit - '0');
            if (head.contentLength > maxBytes) return tooLarge(maxBytes);
        }
    }
    const bool takesBody =
        head.method != "GET" && head.method != "HEAD" && head.method != "OPTIONS";
    if (!takesBody && head.contentLength > 0) {
        return badRequest(head.method + " requests cannot have a body.");
    }
    if (lengths == 0 && takesBody && head.method != "DELETE") return lengthRequired();
    const std::string_view encoding = head.header("Content-Encoding");
    if (!encoding.empty() && !sameName(encoding, "identity")) return encodedBody();
    const std::string_view expected = head.header("Expect");
    if (expected.empty()) return std::nullopt;
    if (!sameName(expected, "100-continue")) return expectationFailed();
    head.expectsContinue = head.contentLength > 0 && head.minorVersion == 1;
    return std::nullopt;
}

// Some clients send an extra CRLF after a body (RFC 9112 2.2).
constexpr std::size_t kBlankLines = 4;

}  // namespace

bool isTokenByte(unsigned char c) {
    return std::isalnum(c) ||
           (c != 0 && std::string_view("!#$%&'*+-.^_`|~").find(static_cast<char>(c)) !=
                          std::string_view::npos);
}

std::string_view RequestHead::header(std::string_view name) const {
    for (const auto& [key, value] : headers) {
        if (sameName(key, name)) return value;
    }
    return {};
}

std::string_view RequestHead::path() const {
    return std::string_view(target).substr(0, target.find('?'));
}

std::string headText(const RequestHead& head) {
    std::string text =
        head.method + ' ' + head.target + " HTTP/1." + std::to_string(head.minorVersion) + "\r\n";
    for (const auto& [name, value] : head.headers) {
        if (sameName(name, "Range")) continue;
        text.append(name).append(": ").append(value).append("\r\n");
    }
    return text + "\r\n";
}

std::size_t bodyLimit(const RequestHead& head, const HttpLimits& limits) {
    for (const LargeBodies& route : limits.large) {
        if (head.method == route.method && head.path() == route.path) return route.bytes;
    }
    return limits.bodyBytes;
}

HeadOutcome readHead(std::string_view text, const HttpLimits& limits) {
    HeadOutcome outcome;
    RequestHead& head = outcome.head;
    outcome.problem = readRequestLine(nextLine(text), head, limits);
    if (outcome.problem) return outcome;
    while (!outcome.problem && !text.empty()) {
        const std::string_view line = nextLine(text);
        if (line.empty()) break;
        outcome.problem = readHeaderLine(line, head);
        if (!outcome.problem && head.headers.size() > limits.headers) {
            outcome.problem = headTooLarge(limits.headBytes, limits.headers);
        }
    }
    if (!outcome.problem) outcome.problem = readBodyHeaders(head, limits);
    const std::size_t hosts = countOf(head, "Host");
    if (!outcome.problem && (hosts > 1 || (hosts == 0 && head.minorVersion == 1))) {
        outcome.problem = badRequest("A request requires exactly one Host header.");
    }
    if (!outcome.problem && hosts == 0 && !head.authority.empty()) {
        head.headers.emplace_back("Host", head.authority);
    }
    // The authority of the target replaces the header (RFC 9112 3.2.2).
    for (auto& [name, value] : head.headers) {
        if (!head.authority.empty() && sameName(name, "Host")) value = head.authority;
    }
    head.keepAlive = head.minorVersion == 1;
    for (const auto& [name, value] : head.headers) {
        if (sameName(name, "Connection") && contains(value, "close")) head.keepAlive = false;
    }
    return outcome;
}

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
