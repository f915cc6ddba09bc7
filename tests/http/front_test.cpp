// The HTTP server alone, with test handlers: connections, streams, disconnects, shutdown.
#include "scene/import/sandbox/jail.h"
#include "server/http/http_server.h"
#include "tests/support/raw_client.h"

#include <gtest/gtest.h>

#include <signal.h>
#include <sys/socket.h>
#include <sys/time.h>

#include <atomic>
#include <cstdio>
#include <cstring>
#include <future>
#include <thread>

namespace clerestory::test {
namespace {

using std::chrono::milliseconds;

template <class Condition>
bool soon(Condition condition) {
    for (int i = 0; i < 2000 && !condition(); ++i) std::this_thread::sleep_for(milliseconds(5));
    return condition();
}

HttpLimits quickLimits() {
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

    std::atomic<int> waiting{0};      // in /wait
    std::atomic<int> leavers{0};      // disconnects that /wait has seen
    std::atomic<int> streamed{0};     // pieces of /stream that were taken
    std::atomic<int> streamsDone{0};  // that ended

private:
    Answer respond(const Call& call) {
        if (call.path == "/throw") throw std::runtime_error("the inside");
        if (call.path == "/client") return {.type = "text/plain", .body = call.client};
        if (call.path == "/big") return {.type = "image/x", .body = std::string(8 << 20, 'b')};
        if (call.path == "/wait") return wait(call);
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

TEST(Front, PipelinedRequestsAreAnsweredInOrder) {
    LocalHttpServer server;
    RawClient client(server.port());
    client.send(get("/a") + get("/quick") + post("/b", "body") + get("/c?x=1"));
    for (const char* body : {"GET /a ", "quick", "POST /b body", "GET /c "}) {
        std::string text;
        // One by one, so that none takes bytes of the next.
        while (bodyOf(text).size() < std::strlen(body)) {
            char c = 0;
            ASSERT_EQ(::recv(client.socket(), &c, 1, 0), 1);
            text += c;
        }
        EXPECT_EQ(bodyOf(text), body);
        EXPECT_EQ(statusOf(text), 200);
        EXPECT_NE(headerOf(text, "Content-Security-Policy").find("frame-ancestors 'none'"),
                  std::string::npos);
        EXPECT_EQ(headerOf(text, "X-Content-Type-Options"), "nosniff");
        EXPECT_FALSE(headerOf(text, "X-Request-Id").empty());
    }
}

TEST(Front, ForwardedHeadersOfUntrustedClientsAreIgnored) {
    LocalHttpServer server;
    EXPECT_EQ(
        bodyOf(ask(server.port(), get("/client", "REMOTE_ADDR: 6.6.6.6\r\n"), 5, "127.0.0.9")),
        "127.0.0.9");
}

TEST(Front, ExceptionsDoNotLeakInternals) {
    LocalHttpServer server;
    const std::string answer = ask(server.port(), get("/throw"));
    EXPECT_EQ(statusOf(answer), 500);
    EXPECT_EQ(answer.find("the inside"), std::string::npos);
    EXPECT_EQ(answer.find("EXCEPTION"), std::string::npos);
}

TEST(Front, ExpectContinueIsAnswered) {
    LocalHttpServer server;
    RawClient client(server.port());
    client.send(
        "POST /b HTTP/1.1\r\nHost: localhost\r\nContent-Length: 4\r\nExpect: 100-continue\r\n\r\n");
    EXPECT_EQ(client.receive(0.2), "HTTP/1.1 100 Continue\r\n\r\n");
    client.send("body");
    EXPECT_EQ(bodyOf(client.answer(5)), "POST /b body");
}

HttpLimits limitsWithALargeRoute() {
    HttpLimits limits = quickLimits();
    limits.large = {{"POST", "/large", 4 << 20}};
    limits.largeBytes = 5 << 20;
    return limits;
}

std::string largeHead(std::size_t size) {
    return "POST /large HTTP/1.1\r\nHost: localhost\r\nContent-Length: " + std::to_string(size) +
           "\r\n\r\n";
}

TEST(Front, LargeBodiesHaveAMinimumRate) {
    LocalHttpServer server(limitsWithALargeRoute());
    std::string body(3 << 20, 'x');
    body.back() = '!';
    RawClient client(server.port());
    ASSERT_TRUE(client.send(largeHead(body.size())));
    for (std::size_t at = 0; at < body.size(); at += 1 << 20) {  // longer than quickLimits().body
        ASSERT_TRUE(client.send(std::string_view(body).substr(at, 1 << 20)));
        std::this_thread::sleep_for(milliseconds(200));
    }
    const std::string answer = client.answer(10);
    EXPECT_EQ(statusOf(answer), 200);
    EXPECT_EQ(bodyOf(answer), "POST /large " + body);

    RawClient slow(server.port());
    ASSERT_TRUE(slow.send(largeHead(body.size())));
    ASSERT_TRUE(slow.send(std::string(100'000, 'x')));
    EXPECT_EQ(statusOf(slow.answer(10)), 408);
    EXPECT_EQ(statusOf(ask(server.port(), largeHead((4 << 20) + 1))), 413);
}

TEST(Front, ConcurrentLargeBodiesAreBounded) {
    LocalHttpServer server(limitsWithALargeRoute());
    RawClient first(server.port());
    const std::string body(4 << 20, 'x');
    ASSERT_TRUE(first.send(largeHead(body.size())));
    ASSERT_TRUE(first.send(std::string_view(body).substr(0, body.size() - 1)));
    ASSERT_TRUE(soon([&] { return server.counters().open == 1; }));
    const std::string refused = ask(server.port(), largeHead(2 << 20));
    EXPECT_EQ(statusOf(refused), 503);
    EXPECT_NE(refused.find("bodiesFull"), std::string::npos) << refused;
    EXPECT_EQ(statusOf(ask(server.port(), post("/small", "body"))), 200);
    ASSERT_TRUE(first.send("x"));
    EXPECT_EQ(statusOf(first.answer(10)), 200);
    const std::string again = ask(server.port(), largeHead(2 << 20) + std::string(2 << 20, 'y'));
    EXPECT_EQ(statusOf(again), 200);
}

TEST(Front, Http10ConnectionsAreClosedAfterTheResponse) {
    LocalHttpServer server;
    RawClient client(server.port());
    client.send("GET /a HTTP/1.0\r\n\r\n");
    const std::string answer = client.receive(5);
    EXPECT_EQ(bodyOf(answer), "GET /a ");
    EXPECT_EQ(headerOf(answer, "Connection"), "close");
    RawClient streams(server.port());
    streams.send("GET /stream?n=3 HTTP/1.0\r\n\r\n");
    EXPECT_EQ(bodyOf(streams.receive(5)).size(), 3u * 65536u)
        << "no chunks, which it could not read";
}

TEST(Front, HeadResponsesHaveNoBody) {
    LocalHttpServer server;
    RawClient client(server.port());
    client.send(
        "HEAD /quick HTTP/1.1\r\nHost: localhost\r\n\r\nHEAD /a HTTP/1.1\r\nHost: "
        "localhost\r\n\r\n");
    const std::string both = client.receive(0.3);
    EXPECT_EQ(both.find("quick"), std::string::npos);
    EXPECT_EQ(both.rfind("HTTP/1.1 200"), both.find("HTTP/1.1 200", 1)) << "two answers";
    EXPECT_TRUE(both.ends_with("\r\n\r\n"));
}

TEST(Front, AnswersWithoutABodyHaveNoLength) {
    LocalHttpServer server;
    for (const char* path : {"/nothing", "/same"}) {
        RawClient client(server.port());
        client.send(get(path, "Connection: close\r\n"));
        const std::string answer = client.receive(5);
        EXPECT_TRUE(answer.starts_with("HTTP/1.1 ")) << answer;
        EXPECT_EQ(headerOf(answer, "Content-Length"), "") << answer;
    }
}

TEST(Front, RangesAndAbsoluteTargetsAreReadAsTheStandardSays) {
    LocalHttpServer server;
    for (const char* range : {"bytes=0-1", "bytes=9-1", "bytes=a", "lines=1-2", ""}) {
        const std::string answer =
            ask(server.port(), get("/a", "Range: " + std::string(range) + "\r\n"));
        EXPECT_EQ(statusOf(answer), 200) << range;
        EXPECT_EQ(bodyOf(answer), "GET /a ") << range;
    }
    EXPECT_EQ(bodyOf(ask(server.port(), "GET http://localhost/a HTTP/1.1\r\nHost: b\r\n\r\n")),
              "GET /a ");
}

TEST(Front, AStreamWaitsForItsReader) {
    LocalHttpServer server;
    RawClient client(server.port(), nullptr, 4096);
    client.send(get("/stream?n=1000"));
    ASSERT_TRUE(soon([&] { return server.streamed > 0; }));
    std::this_thread::sleep_for(milliseconds(200));
    const int ahead = server.streamed;
    EXPECT_LT(ahead, 200) << "64 MB would be 1,000 pieces";
    std::string all = client.receive(0.05);
    EXPECT_TRUE(soon([&] { return server.streamed > ahead; })) << "it continues as it is read";
}

TEST(Front, AStreamThatIsNotReadEnds) {
    LocalHttpServer server;
    RawClient client(server.port(), nullptr, 4096);
    client.send(get("/stream?n=1000000"));
    EXPECT_TRUE(soon([&] { return server.streamsDone == 1; }));
    EXPECT_EQ(server.counters().stalled, 1u);
}

TEST(Front, AStreamEndsWhenTheClientDisconnects) {
    LocalHttpServer server;
    {
        RawClient client(server.port());
        client.send(get("/stream?n=1000000"));
        ASSERT_TRUE(soon([&] { return server.streamed > 2; }));
    }
    EXPECT_TRUE(soon([&] { return server.streamsDone == 1; }));
}

TEST(Front, CompleteResponsesHoldNoWorkerWhileSent) {
    LocalHttpServer server(quickLimits(), 2);
    std::vector<RawClient> slow;
    for (int i = 0; i < 6; ++i) {
        slow.emplace_back(server.port(), nullptr, 4096);
        slow.back().send(get("/big"));
    }
    // Two workers and six clients that read nothing: the next client is still answered immediately.
    std::this_thread::sleep_for(milliseconds(100));
    EXPECT_EQ(bodyOf(ask(server.port(), get("/a"), 30)), "GET /a ");
    EXPECT_TRUE(soon([&] { return server.counters().stalled == 6; })) << "closed in the end";
}

TEST(Front, AReaderAtTheMinimumRateReceivesEverything) {
    HttpLimits limits = quickLimits();
    if (kSanitized) limits.write = milliseconds(3000);  // its reader is slow beyond its pauses
    LocalHttpServer server(limits);
    RawClient client(server.port(), nullptr, 1 << 18);
    client.send(get("/big", "Connection: close\r\n"));
    std::string all;
    for (;;) {  // takes longer than the write limit; the server closes
        char some[32768];
        const ssize_t n = ::recv(client.socket(), some, sizeof some, 0);
        if (n <= 0) break;
        all.append(some, static_cast<std::size_t>(n));
        std::this_thread::sleep_for(milliseconds(3));
    }
    EXPECT_EQ(bodyOf(all).size(), 8u << 20);
}

// A4 of the catalogue of attacks: the kernel takes a megabyte at once, and says nothing while it is
// read. This reader needs longer for a megabyte than the limit, with a buffer of the usual size.
TEST(Front, ASteadyReaderReceivesEverythingHoweverTheKernelBuffers) {
    HttpLimits limits = quickLimits();
    limits.write = milliseconds(kSanitized ? 3000 : 700);
    LocalHttpServer server(limits);
    RawClient client(server.port());
    client.send(get("/big", "Connection: close\r\n"));
    std::size_t received = 0;
    const auto begun = Clock::now();
    for (;;) {
        char some[65536];
        const ssize_t n = ::recv(client.socket(), some, sizeof some, 0);
        if (n <= 0) break;
        received += static_cast<std::size_t>(n);
        // A megabyte a second.
        std::this_thread::sleep_until(begun + std::chrono::microseconds(received));
    }
    EXPECT_GT(received, 8u << 20);
    EXPECT_EQ(server.counters().stalled, 0u);
}

// A5 of the catalogue of attacks.
TEST(Front, ResponsesAreCappedForEachClientAndHoldNoThread) {
    HttpLimits limits = quickLimits();
    limits.write = milliseconds(30000);
    limits.unsentBytes = 20 << 20;
    LocalHttpServer server(limits, 2);
    std::vector<RawClient> slow;
    for (int i = 0; i < 8; ++i) {
        slow.emplace_back(server.port(), "127.0.0.2", 4096);
        slow.back().send(get("/big"));
    }
    // The first response, then perhaps one more; the others are refused, and no client waits.
    int refused = 0;
    for (RawClient& client : slow) {
        char some[13] = "";
        ASSERT_EQ(::recv(client.socket(), some, sizeof some - 1, MSG_WAITALL), 12);
        refused += std::string_view(some) == "HTTP/1.1 503";
    }
    EXPECT_GE(refused, 6);
    EXPECT_EQ(bodyOf(ask(server.port(), get("/a"), 10)), "GET /a ");
    EXPECT_EQ(bodyOf(ask(server.port(), get("/big"), 10, "127.0.0.3")).size(), 8u << 20)
        << "another client has its share";
    slow.clear();
}

// A5: readers that read, but slowly, kept the process alive after SIGTERM.
TEST(Front, StoppingWaitsForReadersOnceForTheWriteLimit) {
    LocalHttpServer server;
    RawClient client(server.port(), nullptr, 4096);
    client.send(get("/big"));
    std::atomic<bool> ending{false};
    std::thread reader([&] {
        char some[8192];  // more than 4 KB within the limit
        while (!ending && ::recv(client.socket(), some, sizeof some, MSG_DONTWAIT) != 0) {
            std::this_thread::sleep_for(milliseconds(50));
        }
    });
    EXPECT_TRUE(soon([&] { return server.counters().open == 1; }));
    std::this_thread::sleep_for(milliseconds(100));
    const auto begun = Clock::now();
    server.stop();
    std::printf("stopped after %.1f s, with a reader of 160 KB a second and 8 MB to read\n",
                std::chrono::duration<double>(Clock::now() - begun).count());
    ending = true;
    reader.join();
    EXPECT_EQ(server.counters().stalled, 1u);
}

// A12: four heads that announced large bodies kept those of all other clients out.
TEST(Front, LargeBodiesOfOneClientLeaveRoomForOthers) {
    HttpLimits limits = limitsWithALargeRoute();
    limits.body = milliseconds(30000);
    limits.largeBytes = 8 << 20;
    LocalHttpServer server(limits);
    std::vector<RawClient> heavy;
    int refused = 0;
    for (int i = 0; i < 4; ++i) {
        heavy.emplace_back(server.port(), "127.0.0.2");
        ASSERT_TRUE(heavy.back().send(largeHead(2 << 20)));
    }
    for (RawClient& client : heavy) refused += statusOf(client.answer(0.3)) == 503;
    EXPECT_EQ(refused, 2);
    const std::string body(2 << 20, 'y');
    EXPECT_EQ(statusOf(ask(server.port(), largeHead(body.size()) + body, 10, "127.0.0.3")), 200);
    heavy.clear();
}

// A12: connections.
TEST(Front, TheClientWithTheMostConnectionsLosesOneFirst) {
    HttpLimits limits = quickLimits();
    limits.connections = 16;
    limits.idle = milliseconds(60000);
    LocalHttpServer server(limits);
    RawClient moderate(server.port(), "127.0.0.3");
    ASSERT_TRUE(soon([&] { return server.counters().open == 1; }));
    std::vector<RawClient> heavy;
    for (int i = 0; i < 100; ++i) heavy.emplace_back(server.port(), "127.0.0.2");
    ASSERT_TRUE(soon([&] { return server.counters().accepted == 101; }));
    moderate.send(get("/a"));
    EXPECT_EQ(bodyOf(moderate.answer(10)), "GET /a ") << "though it was idle longest";
}

TEST(Front, HandlersLearnThatTheClientDisconnected) {
    LocalHttpServer server;
    {
        RawClient closes(server.port()), resets(server.port()), halfCloses(server.port());
        closes.send(get("/wait"));
        resets.send(get("/wait"));
        halfCloses.send(get("/wait"));
        ASSERT_TRUE(soon([&] { return server.waiting == 3; }));
        EXPECT_EQ(server.leavers, 0);
        halfCloses.halfClose();
        EXPECT_TRUE(soon([&] { return server.leavers == 1; }));
        resets.reset();
        EXPECT_TRUE(soon([&] { return server.leavers == 2; }));
        server.release();
        EXPECT_EQ(bodyOf(halfCloses.answer(5)), "waited") << "it may still be listening";
    }
    EXPECT_TRUE(soon([&] { return server.counters().open == 0; }));
}

// One with a limit of ten minutes stays.
TEST(Front, AConnectionWithoutRequestsIsClosedAtTheLimit) {
    LocalHttpServer server;
    HttpLimits patient = quickLimits();
    patient.idle = milliseconds(600000);
    LocalHttpServer other(patient);
    RawClient client(server.port()), kept(other.port());
    for (RawClient* each : {&client, &kept}) {
        each->send(get("/a"));
        EXPECT_EQ(bodyOf(each->answer(10)), "GET /a ");
    }
    EXPECT_TRUE(client.endsWithin(60)) << "after 0.7 s";
    EXPECT_FALSE(kept.endsWithin(0.2));
    kept.send(get("/b"));
    EXPECT_EQ(bodyOf(kept.answer(10)), "GET /b ");
}

TEST(Front, TheLongestIdleConnectionIsClosed) {
    HttpLimits limits = quickLimits();
    limits.connections = 16;
    limits.idle = milliseconds(60000);
    LocalHttpServer server(limits);
    std::vector<RawClient> idle;
    for (int i = 0; i < 200; ++i) idle.emplace_back(server.port());
    EXPECT_EQ(bodyOf(ask(server.port(), get("/a"))), "GET /a ");
    EXPECT_LE(server.counters().open, 16u);
    EXPECT_GE(server.counters().evicted, 184u);
    // Connections with a running request stay open.
    std::vector<RawClient> busy;
    for (int i = 0; i < 4; ++i) {
        busy.emplace_back(server.port());
        busy.back().send(get("/wait"));
    }
    ASSERT_TRUE(soon([&] { return server.waiting == 4; }));
    for (int i = 0; i < 100; ++i) idle.emplace_back(server.port());
    EXPECT_EQ(bodyOf(ask(server.port(), get("/quick"))), "quick");
    server.release();
    for (RawClient& client : busy) EXPECT_EQ(bodyOf(client.answer(5)), "waited");
}

TEST(Front, RequestsAreRejectedWhenAllWorkersAreBusy) {
    HttpLimits limits = quickLimits();
    limits.connections = 3;
    LocalHttpServer server(limits);
    std::vector<RawClient> busy;
    for (int i = 0; i < 3; ++i) {
        busy.emplace_back(server.port());
        busy.back().send(get("/wait"));
    }
    ASSERT_TRUE(soon([&] { return server.waiting == 3; }));
    RawClient next(server.port());
    const std::string answer = next.answer(5);
    EXPECT_EQ(statusOf(answer), 503);
    EXPECT_EQ(headerOf(answer, "Content-Type"), "application/problem+json");
    EXPECT_EQ(server.counters().rejected, 1u);
}

TEST(Front, StoppingCompletesRunningAndPartlyReceivedRequests) {
    LocalHttpServer server;
    RawClient running(server.port()), coming(server.port()), idle(server.port());
    running.send(get("/wait"));
    idle.send(get("/a"));
    idle.answer(5);
    coming.send("GET /a HTTP/1.1\r\n");
    ASSERT_TRUE(soon([&] { return server.waiting == 1; }));
    std::thread stopping([&] { server.stopWithoutRelease(); });
    EXPECT_TRUE(idle.endsWithin(5));
    coming.send("Host: localhost\r\n\r\n");
    const std::string answer = coming.receive(5);
    EXPECT_EQ(bodyOf(answer), "GET /a ");
    EXPECT_EQ(headerOf(answer, "Connection"), "close");
    EXPECT_FALSE(RawClient(server.port()).connected());
    server.release();
    EXPECT_EQ(bodyOf(running.answer(5)), "waited");
    stopping.join();
}

// U2: a thousand interrupted calls a second.
TEST(Front, SignalsInterruptNothing) {
    LocalHttpServer server;
    struct sigaction action {};
    action.sa_handler = [](int) {};  // without SA_RESTART: calls end with EINTR
    sigaction(SIGALRM, &action, nullptr);
    const itimerval every{{0, 1000}, {0, 1000}};
    setitimer(ITIMER_REAL, &every, nullptr);
    int failures = 0;
    RawClient client(server.port());
    for (int i = 0; i < 1000; ++i) {
        client.send(get(i % 2 ? "/a" : "/quick"));
        failures += statusOf(client.answer(5)) != 200;
    }
    for (int i = 0; i < 20; ++i) {
        failures += bodyOf(ask(server.port(), get("/big"), 20)).size() != (8u << 20);
    }
    const itimerval never{};
    setitimer(ITIMER_REAL, &never, nullptr);
    signal(SIGALRM, SIG_DFL);
    EXPECT_EQ(failures, 0);
}

}  // namespace
}  // namespace clerestory::test
