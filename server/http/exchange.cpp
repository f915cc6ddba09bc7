#include "server/http/exchange.h"

#include <algorithm>
#include <atomic>
#include <cctype>
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

}  // namespace

Call callOf(const Exchange& exchange) {
    const RequestHead& head = exchange.head;
    return {.method = head.method == "HEAD" ? "GET" : head.method,
            .path = std::string(head.path()),
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
    add("Content-Length", std::to_string(answer.body.size()));
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

}  // namespace clerestory
