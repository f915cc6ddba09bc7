// The HTTP server alone, with test handlers: streams and large responses, and clients that read
// them slowly or not at all.
#include "local_http_server.h"
#include "tests/support/soon.h"

#include <gtest/gtest.h>

#include <sys/socket.h>

#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace clerestory::test {
namespace {

TEST(FrontReaders, AStreamWaitsForItsReader) {
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

TEST(FrontReaders, AStreamThatIsNotReadEnds) {
    LocalHttpServer server;
    RawClient client(server.port(), nullptr, 4096);
    client.send(get("/stream?n=1000000"));
    EXPECT_TRUE(soon([&] { return server.streamsDone == 1; }));
    EXPECT_EQ(server.counters().stalled, 1u);
}

TEST(FrontReaders, AStreamEndsWhenTheClientDisconnects) {
    LocalHttpServer server;
    {
        RawClient client(server.port());
        client.send(get("/stream?n=1000000"));
        ASSERT_TRUE(soon([&] { return server.streamed > 2; }));
    }
    EXPECT_TRUE(soon([&] { return server.streamsDone == 1; }));
}

TEST(FrontReaders, CompleteResponsesHoldNoWorkerWhileSent) {
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

TEST(FrontReaders, AReaderAtTheMinimumRateReceivesEverything) {
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
TEST(FrontReaders, ASteadyReaderReceivesEverythingHoweverTheKernelBuffers) {
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

// The status of a response of which the client reads nothing else.
int statusAlone(const RawClient& client) {
    char some[13] = "";
    if (::recv(client.socket(), some, sizeof some - 1, MSG_WAITALL) != 12) return 0;
    return statusOf(std::string(some) + "\r\n");
}

// Their checks came before any of them counted, and each had its whole response.
TEST(FrontReaders, ResponsesThatAreReadyAtTheSameTimeShareOneLimit) {
    HttpLimits limits = quickLimits();
    limits.write = milliseconds(30000);
    limits.unsentBytes = 40 << 20;
    constexpr int kClients = 12;
    LocalHttpServer server(limits, kClients);
    std::vector<RawClient> slow;
    for (int i = 0; i < kClients; ++i) {
        slow.emplace_back(server.port(), "127.0.0.2", 4096);
        slow.back().send(get("/waitbig"));
    }
    ASSERT_TRUE(soon([&] { return server.waiting == kClients; }));
    server.release();
    int complete = 0;
    for (const RawClient& client : slow) complete += statusAlone(client) == 200;
    EXPECT_EQ(complete, 2) << "of 8 MB each: at most half of 40 MB";
    EXPECT_LE(server.holdings().usage(Pool::responseBytes).total, 20u << 20);
}

// Four addresses that did not read their responses locked out all other clients.
TEST(FrontReaders, LargeResponsesThatAreNotReadRefuseNoSmallOnes) {
    HttpLimits limits = quickLimits();
    limits.write = milliseconds(30000);
    limits.unsentBytes = 20 << 20;
    LocalHttpServer server(limits);
    std::vector<RawClient> slow;
    for (const char* from : {"127.0.0.2", "127.0.0.3", "127.0.0.4"}) {
        slow.emplace_back(server.port(), from, 4096);
        slow.back().send(get("/big"));
        EXPECT_EQ(statusAlone(slow.back()), 200);
    }
    EXPECT_GE(server.holdings().usage(Pool::responseBytes).total, limits.unsentBytes);
    for (const char* from : {"127.0.0.9", "127.0.0.2"}) {
        EXPECT_EQ(bodyOf(ask(server.port(), get("/a"), 10, from)), "GET /a ") << from;
        EXPECT_EQ(bodyOf(ask(server.port(), get("/picture"), 10, from)).size(), 200'000u) << from;
    }
    EXPECT_EQ(statusOf(ask(server.port(), get("/big"), 10, "127.0.0.9")), 503) << "a large one";
}

TEST(FrontReaders, SmallResponsesAreCappedForEachClient) {
    HttpLimits limits = quickLimits();
    limits.write = milliseconds(30000);
    limits.smallUnsentBytes = 2'000'000;
    LocalHttpServer server(limits);
    std::optional<Holdings::Held> unread =
        server.holdings().take(Pool::smallResponseBytes, "127.0.0.2", 900'000);
    ASSERT_TRUE(unread);
    EXPECT_EQ(statusOf(ask(server.port(), get("/picture"), 10, "127.0.0.2")), 503);
    EXPECT_EQ(statusOf(ask(server.port(), get("/picture"), 10, "127.0.0.3")), 200);
    auto others = server.holdings().take(Pool::smallResponseBytes, "127.0.0.4", 1'100'000);
    ASSERT_TRUE(others);
    EXPECT_EQ(statusOf(ask(server.port(), get("/picture"), 10, "127.0.0.3")), 503) << "full";
    EXPECT_EQ(bodyOf(ask(server.port(), get("/a"), 10, "127.0.0.3")), "GET /a ")
        << "a client without unread responses always gets a short one";
}

TEST(FrontReaders, ASharedBodyIsNotCopied) {
    LocalHttpServer server;
    RawClient slow(server.port(), "127.0.0.2", 4096);
    slow.send(get("/shared"));
    EXPECT_EQ(statusAlone(slow), 200);
    EXPECT_EQ(server.shared.use_count(), 2) << "one for the connection";
    EXPECT_EQ(server.holdings().of(Pool::responseBytes, "127.0.0.2"), 8u << 20);
    const std::string whole = ask(server.port(), get("/shared"), 10, "127.0.0.3");
    EXPECT_EQ(bodyOf(whole), *server.shared);
    EXPECT_EQ(headerOf(whole, "Content-Length"), std::to_string(8 << 20));
    const std::string head =
        ask(server.port(), "HEAD /shared HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n",
            10, "127.0.0.4");
    EXPECT_EQ(headerOf(head, "Content-Length"), std::to_string(8 << 20));
    EXPECT_EQ(bodyOf(head), "");
    EXPECT_TRUE(soon([&] { return server.shared.use_count() == 1; })) << "dropped when it stalls";
    EXPECT_EQ(server.holdings().usage(Pool::responseBytes).total, 0u);
}

// 4 KB within the limit were enough, which is 6 hours for a frame of 41 MB.
TEST(FrontReaders, ALargeResponseNeedsAReaderOfItsSize) {
    LocalHttpServer server;
    RawClient client(server.port(), nullptr, 4096);
    client.send(get("/big"));
    const bool ended = soon([&] {
        char some[1024];  // at most 200 KB/s; a thirtieth of 8 MB in 0.5 s is 560 KB/s
        static_cast<void>(::recv(client.socket(), some, sizeof some, MSG_DONTWAIT));
        return server.counters().stalled == 1;
    });
    EXPECT_TRUE(ended);
}

// A5 of the catalogue of attacks.
TEST(FrontReaders, ResponsesAreCappedForEachClientAndHoldNoThread) {
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
TEST(FrontReaders, StoppingWaitsForReadersOnceForTheWriteLimit) {
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

}  // namespace
}  // namespace clerestory::test
