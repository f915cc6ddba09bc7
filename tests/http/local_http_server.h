// An HTTP server with test handlers and short limits.
#pragma once

#include "server/http/http_server.h"
#include "tests/support/raw_client.h"

#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

namespace clerestory::test {

using std::chrono::milliseconds;

inline HttpLimits quickLimits() {
    HttpLimits limits;
    limits.head = milliseconds(400);
    limits.body = milliseconds(400);
    limits.write = milliseconds(500);
    limits.idle = milliseconds(700);
    return limits;
}

class LocalHttpServer {
public:
    explicit LocalHttpServer(const HttpLimits& limits = quickLimits(), std::size_t threads = 4)
        : front_({.port = 0, .threads = threads, .limits = limits},
                 {.quick = [](const Call& call, std::string_view) -> std::optional<Answer> {
                      if (call.path != "/quick") return std::nullopt;
                      return Answer{.type = "text/plain", .body = "quick"};
                  },
                  .respond = [this](const Call& call) { return respond(call); },
                  .refuse =
                      [](const Call& call, const Problem& problem) {
                          return Answer{.status = problem.status,
                                        .type = "application/problem+json",
                                        .body = problemJson(problem, call.requestId)};
                      },
                  .paths = {.open = [](std::string_view) { return true; },
                            .linked = [](std::string_view) { return false; }}}) {
        thread_ = std::thread([this] { front_.serve(); });
    }
    ~LocalHttpServer() { stop(); }
    void stop() {
        if (!thread_.joinable()) return;
        release();
        front_.stop();
        thread_.join();
    }
    void stopWithoutRelease() {
        front_.stop();
        thread_.join();
    }
    void release() {
        if (!released_.exchange(true)) gate_.set_value();
    }
    int port() const { return front_.port(); }
    const ConnectionCounters& counters() const { return front_.counters(); }
    Holdings& holdings() { return front_.holdings(); }

    std::atomic<int> waiting{0};      // in /wait
    std::atomic<int> leavers{0};      // disconnects that /wait has seen
    std::atomic<int> streamed{0};     // pieces of /stream that were taken
    std::atomic<int> streamsDone{0};  // that ended
    // The body of /shared.
    const std::shared_ptr<const std::string> shared =
        std::make_shared<const std::string>(8 << 20, 's');

private:
    Answer respond(const Call& call) {
        if (call.path == "/throw") throw std::runtime_error("the inside");
        if (call.path == "/client") return {.type = "text/plain", .body = call.client};
        if (call.path == "/big") return {.type = "image/x", .body = std::string(8 << 20, 'b')};
        if (call.path == "/picture") return {.type = "image/x", .body = std::string(200'000, 'p')};
        if (call.path == "/shared") {
            Answer answer{.type = "image/x"};
            answer.shared = shared;
            return answer;
        }
        if (call.path == "/wait") return wait(call);
        if (call.path == "/waitbig") {
            wait(call);
            return {.type = "image/x", .body = std::string(8 << 20, 'w')};
        }
        if (call.path == "/nothing") return {.status = 204};
        if (call.path == "/same") return {.status = 304};
        if (call.path == "/stream") return stream(call);
        return {.type = "text/plain", .body = call.method + " " + call.path + " " + call.body};
    }

    Answer wait(const Call& call) {
        call.cancellation->onCancel([this] { ++leavers; });
        ++waiting;
        opened_.wait();
        --waiting;
        call.cancellation->onCancel(nullptr);
        return {.type = "text/plain", .body = "waited"};
    }

    // As many chunks of 64 KB as the query says, or until the client disconnects.
    Answer stream(const Call& call) {
        const int pieces = std::stoi(call.query.find("n")->second);
        Answer answer{.type = "application/x-tar"};
        answer.stream = [this, pieces](const Sink& sink) {
            bool wanted = true;
            for (int i = 0; i < pieces && wanted; ++i) {
                wanted = sink(std::string(65536, static_cast<char>('a' + i % 26)));
                streamed += wanted;
            }
            ++streamsDone;
            return wanted;
        };
        return answer;
    }

    std::promise<void> gate_;
    std::shared_future<void> opened_{gate_.get_future()};
    std::atomic<bool> released_{false};
    HttpServer front_;
    std::thread thread_;
};

}  // namespace clerestory::test
