// The HTTP server alone, with test handlers: requests, connections, disconnects, shutdown.
#include "local_http_server.h"
#include "scene/import/sandbox/jail.h"
#include "tests/support/soon.h"

#include <gtest/gtest.h>

#include <signal.h>
#include <sys/socket.h>
#include <sys/time.h>

#include <cstring>
#include <thread>

namespace clerestory::test {
namespace {

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
