#include "tests/support/attacks.h"

#include "tests/support/clock.h"
#include "tests/support/raw_client.h"
#include "tests/support/soon.h"

#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <thread>

namespace clerestory::test {
namespace {

std::string text(const char* format, double value) {
    char buffer[64];
    std::snprintf(buffer, sizeof buffer, format, value);
    return buffer;
}

// Raises the limit so that a crowd fits into this process.
void raiseDescriptors() {
    rlimit files{};
    getrlimit(RLIMIT_NOFILE, &files);
    files.rlim_cur = files.rlim_max;
    setrlimit(RLIMIT_NOFILE, &files);
}

const std::string kHeadBegun = "POST /v1/frames HTTP/1.1\r\nHost: localhost\r\n";
const std::string kBodyBegun =
    kHeadBegun + "Content-Type: application/json\r\nContent-Length: 400\r\n\r\n{";

// Others' answers while a crowd drips a byte a second, and when the server has had enough of it.
Figure drip(const Target& target, const std::string& name, const std::string& begin, double limit,
            int count) {
    std::vector<RawClient> crowd;
    for (int i = 0; i < count; ++i) crowd.emplace_back(target.server.port());
    const auto start = Clock::now();
    for (RawClient& client : crowd) client.send(begin);
    double worst = 0.0;
    while (secondsSince(start) < std::min(2.0, 0.7 * limit)) {
        for (RawClient& client : crowd) client.send(begin.back() == '{' ? " " : "X");
        const double answer = worstAnswer(target.server.port(), 2);
        worst = answer < 0 ? 1e9 : std::max(worst, answer);
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    int rejected = 0;
    for (RawClient& client : crowd) {
        const double left = limit + target.grace - secondsSince(start);
        rejected += statusOf(client.answer(std::max(left, 0.1))) == 408;
    }
    return {.row = "C1",
            .what = std::to_string(count) + " " + name,
            .figure = "others " + text("%.0f ms", worst) + " at worst; " +
                      std::to_string(rejected) + " of " + std::to_string(count) +
                      " received 408 within " + text("%.1f s", limit + target.grace),
            .bar = "others answered; all received 408 and were closed",
            .held = worst < 1e9 && rejected == count,
            .timely = worst < 1000.0};
}

Figure silence(const Target& target, int count) {
    std::vector<RawClient> crowd;
    for (int i = 0; i < count; ++i) {
        crowd.emplace_back(target.server.port());
        crowd.back().send(get("/healthz"));
    }
    for (RawClient& client : crowd) client.answer(5.0);
    const double worst = worstAnswer(target.server.port());
    const bool closed = crowd.front().endsWithin(target.idle + target.grace);
    return {.row = "C1",
            .what = std::to_string(count) + " kept-alive and silent",
            .figure = "others " + text("%.0f ms", worst) + " at worst; " +
                      (closed ? "closed in time" : "still open"),
            .bar = "others answered; closed at the idle limit",
            .held = worst >= 0 && closed,
            .timely = worst < 1000.0};
}

// Waits until a response has begun to arrive.
void awaitReadable(const RawClient& client, double seconds) {
    pollfd event{.fd = client.socket(), .events = POLLIN, .revents = 0};
    ::poll(&event, 1, static_cast<int>(1000.0 * seconds));
}

// Whether an answer that was not read yet is a refusal.
bool isRefused(const RawClient& client) {
    char line[12] = {};
    return recv(client.socket(), line, sizeof line, MSG_PEEK | MSG_DONTWAIT) == sizeof line &&
           std::string_view(line, sizeof line) == "HTTP/1.1 503";
}

// A large response that is not read, of more than one client's share. A small receive buffer keeps
// the kernel from buffering it.
Figure slowReaders(const Target& target, int count) {
    const std::string body =
        R"({"scene": "six-walls", "width": 1024, "height": 1024, "output": {"format": "npy"}})";
    std::vector<RawClient> crowd;
    for (int i = 0; i < count; ++i) {
        crowd.emplace_back(target.server.port(), nullptr, 4096);
        crowd.back().send(post("/v1/frames", body, "Clerestory-Deadline: 600000\r\n"));
    }
    // A few responses fill the server's buffers; the others wait for these.
    for (int i = 0; i < std::min(count, 4); ++i) awaitReadable(crowd[i], 60.0);
    const double worst = worstAnswer(target.server.port());
    const std::string frame =
        ask(target.server.port(), post("/v1/frames", R"({"scene": "six-walls", "width": 64,
                                                         "height": 48})"),
            30.0);
    std::this_thread::sleep_for(std::chrono::duration<double>(target.write));
    const auto due = Clock::now();
    // Closed by the server: sending fails.
    const auto closes = [&](RawClient& client) {
        while (client.send("x")) {
            if (secondsSince(due) > 2.0 * target.grace) return false;
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
        return true;
    };
    const auto refused = std::count_if(crowd.begin(), crowd.end(), isRefused);
    const auto closed = std::count_if(crowd.begin(), crowd.end(), [&](RawClient& client) {
        return !isRefused(client) && closes(client);
    });
    return {.row = "C1",
            .what = std::to_string(count) + " slow readers of 12 MB",
            .figure = "others " + text("%.0f ms", worst) + " at worst, a frame " +
                      std::to_string(statusOf(frame)) + "; refused " + std::to_string(refused) +
                      ", closed " + std::to_string(closed),
            .bar = "others answered; one client's share at most, closed at the write limit",
            .held = worst >= 0 && statusOf(frame) == 200 && closed > 0 && closed + refused == count,
            .timely = worst < 1000.0};
}

struct Wrong {
    const char* row;
    const char* name;
    std::string request;
    int status;
};

std::vector<Wrong> wrongOnes() {
    const std::string head = kHeadBegun + "Content-Type: application/json\r\n";
    const auto length = [&](const char* value) {
        return head + "Content-Length: " + value + "\r\n\r\n{}";
    };
    std::string many = "GET /healthz HTTP/1.1\r\nHost: localhost\r\n";
    for (int i = 0; i < 2000; ++i) many += "X-" + std::to_string(i) + ": 1\r\n";
    const std::string long4000(4000, 'a');
    return {
        {"R4", "line without end, 1 MB", std::string(1 << 20, 'A'), 414},
        {"R4", "request line without end", "GET /" + std::string(1 << 20, 'a'), 414},
        {"R4", "header without end, 1 MB",
         "GET / HTTP/1.1\r\nHost: localhost\r\nX: " + std::string(1 << 20, 'a'), 431},
        {"R4", "2,000 headers", many + "\r\n", 431},
        {"R4", "chunked body", head + "Transfer-Encoding: chunked\r\n\r\n2\r\n{}\r\n0\r\n\r\n",
         411},
        {"R4", "body without a length", head + "\r\n{}", 411},
        {"R4", "gzip body", length("2\r\nContent-Encoding: gzip"), 415},
        {"R4", "body too long", length("200000000"), 413},
        {"R4", "path of 4,000", get("/" + long4000), 414},
        {"R4", "path of 600", get("/" + std::string(600, 'a')), 414},
        {"R4", "Content-Length abc", length("abc"), 400},
        {"R4", "Content-Length 0x10", length("0x10"), 400},
        {"R4", "Content-Length -1", length("-1"), 400},
        {"R4", "Content-Length +2", length("+2"), 400},
        {"R4", "Content-Length twice", length("2\r\nContent-Length: 3"), 400},
        {"R4", "Content-Length 2, 2", length("2, 2"), 400},
        {"R4", "length and chunks together",
         head + "Content-Length: 4\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\nGET /x "
                "HTTP/1.1\r\n\r\n",
         400},
        {"R4", "blank before a colon", kHeadBegun + "Content-Length : 2\r\n\r\n{}", 400},
        {"R4", "folded header", kHeadBegun + "X: a\r\n b\r\n\r\n", 400},
        {"R4", "bare line feeds", "GET /healthz HTTP/1.1\nHost: localhost\n\n", 400},
        {"R4", "NUL in a header", kHeadBegun + std::string("X: a\0b\r\n\r\n", 10), 400},
        {"R4", "a GET with a body", get("/healthz", "Content-Length: 5\r\n") + "GET /", 400},
        {"R4", "two hosts", get("/healthz", "Host: localhost\r\n"), 400},
        {"R4", "no host", "GET /healthz HTTP/1.1\r\n\r\n", 400},
        {"R4", "unknown expectation", length("2\r\nExpect: wonders"), 417},
        {"R5", "unknown method", "BREW /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n", 501},
        {"R5", "HTTP/3.0", "GET /healthz HTTP/3.0\r\nHost: localhost\r\n\r\n", 505},
        {"R7", "nonsense", "nonsense\r\n\r\n", 400},
        {"R7", "TLS hello", std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", 11), 400},
        {"R7", "HTTP/2 preface", "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", 505},
        {"R7", "SSH greeting", "SSH-2.0-OpenSSH_9.2\r\n", 0},
        {"A2", "a foreign host name", "GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n", 421},
        {"A2", "a form", kHeadBegun + "Content-Type: text/plain\r\nContent-Length: 2\r\n\r\n{}",
         415},
    };
}

}  // namespace

double worstAnswer(int port, int tries) {
    double worst = 0.0;
    for (int i = 0; i < tries; ++i) {
        for (const char* path : {"/healthz", "/v1/renderer"}) {
            const auto start = Clock::now();
            if (statusOf(ask(port, get(path, "Connection: close\r\n"), 10.0)) != 200) return -1.0;
            worst = std::max(worst, 1000.0 * secondsSince(start));
        }
    }
    return worst;
}

std::vector<Figure> slowAttacks(const Target& target) {
    return {silence(target, 64),
            drip(target, "slow heads", kHeadBegun, target.head, 8),
            drip(target, "slow heads", kHeadBegun, target.head, target.crowd),
            drip(target, "slow bodies", kBodyBegun, target.body, 8),
            drip(target, "slow bodies", kBodyBegun, target.body, target.crowd),
            slowReaders(target, 8)};
}

std::vector<Figure> wrongRequests(const Target& target) {
    std::vector<Figure> figures;
    const int port = target.server.port();
    for (const Wrong& wrong : wrongOnes()) {
        const std::size_t before = target.server.residentBytes();
        RawClient client(port);
        client.send(wrong.request);
        if (wrong.status == 0) client.halfClose();  // only part of a line: nothing to answer yet
        const std::string answer = client.receive(5.0);
        const double rise =
            static_cast<double>(target.server.residentBytes()) - static_cast<double>(before);
        const bool one = answer.find("HTTP/1.1 ", 1) == std::string::npos;
        const bool problem =
            wrong.status == 0 || headerOf(answer, "Content-Type") == "application/problem+json";
        figures.push_back(
            {.row = wrong.row,
             .what = wrong.name,
             .figure = std::to_string(statusOf(answer)) + ", " + text("%.2f MB", rise / 1048576.0) +
                       (one ? "" : ", two answers") + (problem ? "" : ", no problem document"),
             .bar = std::to_string(wrong.status) + " and closed, under 2 MB",
             .held = statusOf(answer) == wrong.status && one && problem && rise < 2.0 * 1048576.0});
    }
    return figures;
}

std::vector<Figure> crowds(const Target& target) {
    raiseDescriptors();
    const int port = target.server.port();
    std::vector<Figure> figures;
    {
        std::vector<RawClient> crowd;
        for (int i = 0; i < target.many; ++i) crowd.emplace_back(port);
        const auto open = std::count_if(crowd.begin(), crowd.end(),
                                        [](const RawClient& c) { return c.connected(); });
        const double worst = worstAnswer(port);
        figures.push_back({.row = "C3",
                           .what = std::to_string(open) + " open connections",
                           .figure = "others " + text("%.0f ms", worst) + " at worst",
                           .bar = "others answered",
                           .held = open == target.many && worst >= 0,
                           .timely = worst < 1000.0});
    }
    {
        const std::size_t before = target.server.descriptors();
        for (int i = 0; i < 300; ++i) {
            RawClient client(port);
            client.send(post("/v1/frames", R"({"scene": "six-walls"})").substr(0, 100));
            client.reset();
        }
        for (int i = 0; i < 1000; ++i) {
            RawClient client(port);
            client.send("GET /healthz HTTP/1.1\r\n");
            client.halfClose();
        }
        worstAnswer(port, 1);
        std::size_t after = target.server.descriptors();
        soon([&] {
            after = target.server.descriptors();
            return after <= before;
        });
        figures.push_back({.row = "C2",
                           .what = "300 resets, 1,000 half-closes",
                           .figure = std::to_string(before) + " descriptors before, " +
                                     std::to_string(after) + " after",
                           .bar = "back to the start",
                           .held = after <= before});
    }
    {
        double worst = 0.0;
        std::vector<std::thread> threads;
        std::mutex mutex;
        for (int i = 0; i < 16; ++i) {
            threads.emplace_back([&] {
                for (int k = 0; k < 20; ++k) {
                    const double answer = worstAnswer(port, 1);
                    const std::lock_guard lock(mutex);
                    worst = answer < 0 ? 1e9 : std::max(worst, answer);
                }
            });
        }
        for (std::thread& thread : threads) thread.join();
        figures.push_back({.row = "C3",
                           .what = "bursts of connections",
                           .figure = "others " + text("%.0f ms", worst) + " at worst",
                           .bar = "none waits for a second SYN (1,000 ms)",
                           .held = worst < 1e9,
                           .timely = worst < 1000.0});
    }
    return figures;
}

std::vector<Figure> failingAccepts() {
    const ServerProcess server({"--scene", "six-walls"}, [] {
        ::setenv("LD_PRELOAD", CLERESTORY_FAILING_ACCEPT, 1);
        ::setenv("ASAN_OPTIONS", "verify_asan_link_order=0", 1);
    });
    constexpr int kAsked = 100;
    int answered = 0;
    for (int i = 0; i < kAsked; ++i) {
        answered += statusOf(ask(server.port(), get("/healthz", "Connection: close\r\n"))) == 200;
    }
    const std::string metrics = ask(server.port(), get("/metrics", "Connection: close\r\n"));
    const std::string name = "clerestory_connection_events{event=\"acceptError\"} ";
    const std::size_t at = metrics.find(name);
    const int errors = at == std::string::npos ? 0 : std::atoi(metrics.c_str() + at + name.size());
    return {{.row = "C3",
             .what = "every other accept() fails, with ten errors in turn",
             .figure = std::to_string(answered) + " of " + std::to_string(kAsked) + " answered, " +
                       std::to_string(errors) + " errors",
             .bar = "all answered",
             .held = answered == kAsked && errors >= kAsked}};
}

std::vector<std::string> hostilePaths() {
    const std::vector<std::string> up = {
        "../",    "..%2f",           "%2e%2e/",  "%2e%2e%2f", "..\\",     "..%5c", "....//", "..;/",
        "..%00/", "%252e%252e%252f", "..%c0%af", "%c0%ae/",   "..%u2215", "./../", "/../"};
    const std::vector<std::string> ends = {
        "etc/passwd",     "etc/passwd%00.js",    "proc/self/environ", "index.html/../x",
        "CMakeCache.txt", "server/cli/main.cpp", "etc%2fpasswd"};
    const std::vector<std::string> begins = {"/", "/v1/scenes/", "/web/", "/v1/jobs/",
                                             "/v1/jobs/x/pictures/"};
    std::vector<std::string> paths;
    for (std::size_t i = 0; paths.size() < 500; ++i) {
        const std::string& step = up[i % up.size()];
        std::string path = begins[(i / up.size()) % begins.size()];
        for (std::size_t k = 0; k <= i % 6; ++k) path += step;
        paths.push_back(path + ends[(i / 7) % ends.size()]);
    }
    return paths;
}

std::vector<Figure> pathAttacks(const Target& target) {
    int held = 0;
    const std::vector<std::string> paths = hostilePaths();
    for (const std::string& path : paths) {
        const std::string answer = ask(target.server.port(), get(path, "Connection: close\r\n"));
        const int status = statusOf(answer);
        held += (status == 404 || status == 400) && answer.find("root:") == std::string::npos;
    }
    return {{.row = "R6",
             .what = std::to_string(paths.size()) + " paths that lead out",
             .figure = std::to_string(held) + " refused",
             .bar = "all 404 or 400",
             .held = held == static_cast<int>(paths.size())}};
}

}  // namespace clerestory::test
