// Attacks on a real server, with limits reduced so that the tests are short.
#include "tests/support/attacks.h"
#include "tests/support/overload.h"
#include "tests/support/raw_client.h"
#include "tests/support/soon.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <thread>

namespace clerestory::test {
namespace {

const std::vector<std::string> kQuick = {"--scene",        "six-walls", "--head-seconds",  "1",
                                         "--body-seconds", "1",         "--write-seconds", "1",
                                         "--idle-seconds", "2"};

void expectAll(const std::vector<Figure>& figures) {
    for (const Figure& f : figures) {
        EXPECT_TRUE(f.held) << f.row << " " << f.what << ": " << f.figure << " (bar: " << f.bar
                            << ")";
    }
}

TEST(Attacks, TheServerSurvivesEachAttack) {
    const ServerProcess server(kQuick);
    ASSERT_TRUE(server.waitUntilReady());
    const Target target{
        .server = server, .head = 1, .body = 1, .write = 1, .idle = 2, .crowd = 60, .grace = 20};
    expectAll(wrongRequests(target));
    expectAll(pathAttacks(target));
    expectAll(slowAttacks(target));
    expectAll(crowds(target));
    expectAll(connectionFloods(target, 2'000));
    EXPECT_EQ(statusOf(ask(server.port(), slowFrame(), 60)), 200) << "and it still draws";
}

// Clients that wait for light that takes long leave threads for all other clients.
TEST(Attacks, WaitingForLightLeavesThreads) {
    const ServerProcess server({"--scene", "chapel"});
    ASSERT_TRUE(server.waitUntilReady());
    std::atomic<int> waited{0}, answered{0}, pending{20};
    std::vector<std::thread> clients;
    for (int i = 0; i < 20; ++i) {
        clients.emplace_back([&, i] {
            httplib::Client client("127.0.0.1", server.port());
            client.set_read_timeout(300);
            // Another intensity needs another light.
            const std::string body = R"({"scene": "chapel", "width": 32, "height": 24, "effects": )"
                                     R"({"indirectLight": true}, "environment": {"intensity": )" +
                                     std::to_string(1.0 + 0.01 * i) + "}}";
            const auto answer =
                client.Post("/v1/frames", {{"Prefer", "wait=60"}}, body, "application/json");
            if (answer && answer->status == 200) {
                ++(answer->has_header("Preference-Applied") ? waited : answered);
            }
            --pending;
        });
    }
    double most = 0.0;
    while (pending > 0) {
        httplib::Client client("127.0.0.1", server.port());
        const auto metrics = client.Get("/metrics");
        ASSERT_TRUE(metrics);
        const std::string name = "clerestory_held{pool=\"waits\"} ";
        const std::size_t at = metrics->body.find(name);
        ASSERT_NE(at, std::string::npos);
        most = std::max(most, std::stod(metrics->body.substr(at + name.size())));
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    for (std::thread& client : clients) client.join();
    EXPECT_LE(most, 4.0) << "the share of one address";
    EXPECT_GT(waited, 0);
    EXPECT_GT(answered, 0) << "at once, with the light of the environment";
}

// C3: descriptors run out, and come back.
TEST(Attacks, TheServerWorksWithFewDescriptors) {
    const ServerProcess server(kQuick, [] {
        const rlimit few{256, 256};
        setrlimit(RLIMIT_NOFILE, &few);
    });
    ASSERT_TRUE(server.waitUntilReady());
    const Target target{.server = server, .many = 400, .grace = 20};
    expectAll(crowds(target));
    EXPECT_EQ(statusOf(ask(server.port(), slowFrame(), 60)), 200);
    // Nearly none: not even enough for the connections that it would like to have.
    const ServerProcess tight({"--scene", "six-walls"}, [] {
        const rlimit few{40, 40};
        setrlimit(RLIMIT_NOFILE, &few);
    });
    ASSERT_TRUE(tight.waitUntilReady());
    std::vector<RawClient> crowd;
    for (int i = 0; i < 200; ++i) crowd.emplace_back(tight.port());
    EXPECT_EQ(statusOf(ask(tight.port(), get("/healthz"), 10)), 200);
    crowd.clear();
    EXPECT_EQ(statusOf(ask(tight.port(), slowFrame(), 60)), 200);
}

TEST(Attacks, AcceptErrorsDoNotEndTheServer) {
    expectAll(failingAccepts());
}

// D1: a log without a reader does not block the server.
TEST(Attacks, LogLinesAreDroppedWhenTheReaderBlocks) {
    static int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    const ServerProcess server({"--scene", "six-walls", "--log-level", "debug"},
                               [] { ::dup2(ends[1], 2); });
    RawClient client(server.port());
    int answered = 0;
    for (int i = 0; i < 12'000; ++i) {
        client.send(get("/healthz"));
        answered += statusOf(client.answer(10)) == 200;
    }
    EXPECT_EQ(answered, 12'000);
    const std::string metrics = ask(server.port(), get("/metrics"));
    EXPECT_THAT(metrics, testing::ContainsRegex("clerestory_log_lines_dropped [1-9]"));
    ::close(ends[0]);
    ::close(ends[1]);
}

// L1, L2. Times are reported, not asserted.
TEST(Overload, FourfoldOverloadIsRejectedImmediatelyAndTheRestIsServed) {
    const ServerProcess server({"--scene", "six-walls", "--queue", "8"});
    ASSERT_TRUE(server.waitUntilReady());
    const Overload load = overload(server, 4.0, 3.0);
    const int done = countOf(load.frames, 200), refused = countOf(load.frames, 503);
    EXPECT_EQ(done + refused, static_cast<int>(load.frames.size()))
        << "every request has a response";
    EXPECT_GT(refused, 0);
    EXPECT_GT(done, 0);
    for (const SentRequest& shot : load.frames) EXPECT_TRUE(shot.status != 503 || shot.saysWhen);
    EXPECT_EQ(countOf(load.health, 200), static_cast<int>(load.health.size()));
    std::cout << "one frame " << load.serviceMs << " ms; done " << done << " in 3 s, p99 "
              << percentile(load.frames, 200, 0.99) << " ms; refused " << refused << ", p99 "
              << percentile(load.frames, 503, 0.99) << " ms; health p99 "
              << percentile(load.health, 200, 0.99) << " ms\n";
}

// L3.
TEST(Overload, AWellBehavedClientIsNotRejectedDuringAFlood) {
    const ServerProcess server({"--scene", "six-walls"});
    ASSERT_TRUE(server.waitUntilReady());
    const Flood result = flood(server, 2.0);
    EXPECT_GT(result.duringFlood.size(), 3u);
    EXPECT_EQ(countOf(result.duringFlood, 200), static_cast<int>(result.duringFlood.size()));
    EXPECT_GT(countOf(result.flooder, 503), 0);
    EXPECT_GT(countOf(result.flooder, 200), 0);
    EXPECT_EQ(countOf(result.flooder, 0), 0);
    std::cout << "well-behaved clients: p99 alone " << percentile(result.alone, 200, 0.99)
              << " ms, during the flood " << percentile(result.duringFlood, 200, 0.99) << " ms\n";
}

// U1.
TEST(Shutdown, UnderLoadAllResponsesAreComplete) {
    const ShutdownCounts endings = endUnderLoad(3, {"--scene", "six-walls"});
    EXPECT_EQ(endings.cleanExits, 3);
    EXPECT_EQ(endings.broken, 0);
    EXPECT_GT(endings.answered, 0);
    std::cout << endings.answered << " answered, " << endings.refused << " refused, "
              << endings.notReached << " not reached; slowest exit " << endings.slowestExit
              << " s\n";
}

// U2: signals without effect.
TEST(Shutdown, OtherSignalsDoNotEndTheServer) {
    const ServerProcess server({"--scene", "six-walls"});
    ASSERT_TRUE(server.waitUntilReady());
    int failures = 0;
    for (int i = 0; i < 50; ++i) {
        for (const int number : {SIGHUP, SIGPIPE, SIGWINCH, SIGCHLD, SIGCONT, SIGURG}) {
            server.signal(number);
        }
        failures += statusOf(ask(server.port(), slowFrame(), 60)) != 200;
    }
    EXPECT_EQ(failures, 0);
}

TEST(Shutdown, ASecondSignalEndsTheServerImmediately) {
    ServerProcess server({"--scene", "chapel"});
    ASSERT_TRUE(server.waitUntilReady());
    RawClient busy(server.port());
    busy.send(post("/v1/frames", R"({"scene": "chapel", "width": 2048, "height": 2048,
                                     "accuracy": "fine"})"));
    ASSERT_TRUE(within(std::chrono::seconds(30),
                       [&] { return metric(server.port(), "clerestory_queue_depth") >= 1; }));
    server.signal(SIGTERM);
    // The first signal is handled once the server accepts no connections.
    ASSERT_TRUE(
        within(std::chrono::seconds(30), [&] { return !RawClient(server.port()).connected(); }));
    const int status = server.end(SIGTERM);
    EXPECT_TRUE(WIFSIGNALED(status)) << "it waited for the frame";
}

// A1: a token, from the command line to the log.
TEST(Access, ATokenIsRequiredExceptForHealthAndThePage) {
    const std::string file = std::string(CLERESTORY_TEST_OUTPUT) + "/server-token";
    ASSERT_EQ(
        std::system(("mkdir -p '" CLERESTORY_TEST_OUTPUT "' && echo 0123456789-secret-token > '" +
                     file + "'")
                        .c_str()),
        0);
    const ServerProcess server({"--scene", "six-walls", "--token-file", file});
    const std::string with = "Authorization: Bearer 0123456789-secret-token\r\n";
    for (const char* path : {"/healthz", "/", "/style.css"}) {
        EXPECT_EQ(statusOf(ask(server.port(), get(path))), 200) << path;
    }
    for (const char* path : {"/v1/scenes", "/metrics", "/openapi.json", "/nothing"}) {
        const std::string answer = ask(server.port(), get(path));
        EXPECT_EQ(statusOf(answer), 401) << path;
        EXPECT_EQ(headerOf(answer, "WWW-Authenticate"), "Bearer");
        EXPECT_EQ(headerOf(answer, "Content-Type"), "application/problem+json");
        EXPECT_NE(statusOf(ask(server.port(), get(path, with))), 401) << path;
    }
}

// Only in the header that contained it, for any invalid request.
TEST(Access, ATokenIsNeverLoggedOrReturned) {
    static const std::string token = "0123456789-unlogged-token";
    static const std::string folder = CLERESTORY_TEST_OUTPUT "/unlogged";
    std::filesystem::create_directories(folder);
    const std::string file = folder + "/token";
    static const std::string log = folder + "/log";
    std::ofstream(file) << token << "\n";
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
    std::string output;  // all responses of the server
    int asked = 0;
    {
        ServerProcess server(
            {"--scene", "six-walls", "--token-file", file, "--log-level", "debug"},
            [] { ::dup2(::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), 2); });
        const std::vector<std::string> headers = {
            "Authorization: Bearer " + token + "\r\n",
            "authorization: bearer " + token + "\r\n",
            "Authorization: Bearer " + token + "x\r\n",
            "Authorization: Basic " + token + "\r\n",
            "Authorization: " + token + "\r\n",
            "Authorization : Bearer " + token + "\r\n",
            "X: y\r\n Authorization: Bearer " + token + "\r\n",
            "Authorization: Bearer " + token + "\r\nAuthorization: Bearer " + token + "\r\n",
            "Authorization: Bearer " + token + "\r\nContent-Length: -1\r\n",
            "Authorization: Bearer " + token + std::string(20'000, 'x') + "\r\n",
            "Cookie: token=" + token + "\r\n"};
        const std::string body = R"({"scene": "six-walls", "width": 16, "height": 16})";
        const std::vector<std::string> paths = {"/",
                                                "/v1/scenes",
                                                "/v1/scenes/nothing",
                                                "/v1/renderer",
                                                "/metrics",
                                                "/readyz",
                                                "/nothing",
                                                "/openapi.json",
                                                "/healthz",
                                                "/v1/stream",
                                                "/v1/frames?width=16",
                                                "/v1/jobs/x"};
        const auto say = [&](const std::string& request) {
            output += ask(server.port(), request, 10.0);
            ++asked;
        };
        for (const std::string& header : headers) {
            const std::string more = header + "Connection: close\r\n";
            for (const std::string& path : paths) {
                say(get(path, more));
                say(get(path + (path.find('?') == std::string::npos ? "?" : "&") + "token=" + token,
                        more));
            }
            for (const char* path : {"/v1/frames", "/v1/plans", "/v1/sequences", "/v1/scenes"}) {
                say(post(path, body, more));
                say(post(path, "{" + body, more));
            }
        }
        output += ask(server.port(), get("/metrics", headers.front() + "Connection: close\r\n"));
        EXPECT_NE(output.find("clerestory_requests_total"), std::string::npos);
        server.end(SIGTERM);
    }
    std::ifstream stream(log);
    const std::string lines{std::istreambuf_iterator<char>(stream), {}};
    EXPECT_GT(std::count(lines.begin(), lines.end(), '\n'), asked / 2) << "it does log";
    EXPECT_EQ(lines.find(token), std::string::npos);
    EXPECT_EQ(output.find(token), std::string::npos);
}

}  // namespace
}  // namespace clerestory::test
