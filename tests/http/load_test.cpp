// Many clients, full queues, deadlines, shutdown.
#include "tests/support/drawing_gate.h"
#include "tests/support/raw_client.h"
#include "tests/support/soon.h"
#include "tests/support/test_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <future>
#include <set>
#include <thread>

namespace clerestory::test {
namespace {

using nlohmann::json;

std::string pose(int i) {
    return smallFrame(R"("camera": {"position": [)" + std::to_string(0.3 + 0.1 * i) +
                      R"(, 0.5, 0.9], "target": [0, 0, 0]}, "output": {"format": "png"})");
}

TEST(Load, TwoHundredConcurrentRequestsGetTheBytesOfASingleOne) {
    constexpr int kPoses = 5, kClients = 200;
    std::vector<std::string> alone;
    auto client = sharedServer().client();
    for (int i = 0; i < kPoses; ++i) {
        const auto result = postJson(client, "/v1/frames", pose(i));
        ASSERT_TRUE(result);
        ASSERT_EQ(result->status, 200) << result->body;
        alone.push_back(result->body);
    }
    EXPECT_NE(alone[0], alone[1]);
    std::vector<std::string> together(kClients);
    std::vector<std::thread> threads;
    for (int i = 0; i < kClients; ++i) {
        threads.emplace_back([&, i] {
            auto own = sharedServer().client();
            const auto result = postJson(own, "/v1/frames", pose(i % kPoses));
            together[static_cast<std::size_t>(i)] = result ? result->body : "no answer";
        });
    }
    for (std::thread& thread : threads) thread.join();
    int different = 0;
    for (int i = 0; i < kClients; ++i) {
        different +=
            together[static_cast<std::size_t>(i)] != alone[static_cast<std::size_t>(i % kPoses)];
    }
    EXPECT_EQ(different, 0);
}

// Of the connections at this port of this process, as the server accepted them: whether small
// segments are sent at once (TCP_NODELAY).
std::vector<bool> sendAtOnce(int port) {
    std::vector<bool> result;
    for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
        const int fd = std::stoi(entry.path().filename());
        sockaddr_in own{}, peer{};
        socklen_t ownSize = sizeof own, peerSize = sizeof peer;
        if (getsockname(fd, reinterpret_cast<sockaddr*>(&own), &ownSize) != 0) continue;
        if (own.sin_family != AF_INET || ntohs(own.sin_port) != port) continue;
        if (getpeername(fd, reinterpret_cast<sockaddr*>(&peer), &peerSize) != 0) continue;
        int on = 0;
        socklen_t size = sizeof on;
        EXPECT_EQ(getsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, &size), 0);
        result.push_back(on != 0);
    }
    return result;
}

// A delayed acknowledgement, which small responses suffer without TCP_NODELAY, costs every request
// 40 ms once the connection is established.
TEST(Load, KeepAliveRequestsDoNotWaitForDelayedAcknowledgements) {
    auto client = sharedServer().client();
    std::vector<double> milliseconds;
    for (int i = 0; i < 100; ++i) {
        const auto start = Clock::now();
        const auto result = client.Get("/v1/renderer");
        ASSERT_TRUE(result);
        milliseconds.push_back(millisecondsSince(start));
    }
    milliseconds.erase(milliseconds.begin(), milliseconds.begin() + 50);  // quick acknowledgements
    std::sort(milliseconds.begin(), milliseconds.end());
    std::printf("a request takes %.2f ms (p50), %.2f ms at least\n", milliseconds[25],
                milliseconds[0]);
    const std::vector<bool> connections = sendAtOnce(sharedServer().server().port());
    EXPECT_THAT(connections, testing::Not(testing::IsEmpty()));
    EXPECT_THAT(connections, testing::Each(true));
}

TEST(Load, AFullQueueRejectsImmediatelyWithRetryAfter) {
    Config config = testConfig();
    config.queue = 2;
    TestServer server(config);
    server.awaitReady();
    auto client = server.client();
    ASSERT_EQ(postJson(client, "/v1/frames", smallFrame())->status, 200);
    auto hold = server.holdRenderer();
    std::vector<int> statuses(2);
    std::vector<std::thread> waiting;
    for (int& status : statuses) {
        waiting.emplace_back([&] {
            auto own = server.client();
            const auto result = postJson(own, "/v1/frames", smallFrame());
            status = result ? result->status : 0;
        });
    }
    ASSERT_TRUE(soon([&] { return server.backend().queue().depth() == 2; }));
    // The renderer is held: a response before `hold` ends cannot have waited for it.
    const auto refused = postJson(client, "/v1/frames", smallFrame());
    EXPECT_EQ(server.backend().queue().depth(), 2u);
    problemOf(refused, 503);
    EXPECT_GE(std::stoi(refused->get_header_value("Retry-After")), 1);
    EXPECT_EQ(client.Get("/healthz")->status, 200) << "still alive";
    EXPECT_EQ(client.Get("/readyz")->status, 200) << "it can draw: room is another matter";
    hold.reset();
    for (std::thread& thread : waiting) thread.join();
    EXPECT_EQ(statuses, (std::vector<int>{200, 200}));
    EXPECT_EQ(client.Get("/readyz")->status, 200);
    EXPECT_THAT(client.Get("/metrics")->body,
                testing::HasSubstr("clerestory_refusals_total{reason=\"queueFull\"} 1"));
}

TEST(Load, AFramePastItsDeadlineIsNotDrawn) {
    Config config = testConfig();
    config.deadlineSeconds = 2.0;
    TestServer server(config);
    server.awaitReady();
    auto client = server.client();
    const auto isDrawn = [&] {
        return postJson(client, "/v1/frames", smallFrame())->status == 200;
    };
    ASSERT_TRUE(soon(isDrawn));
    const std::uint64_t before = server.framesDrawn();
    auto hold = server.holdRenderer();
    const auto start = Clock::now();
    problemOf(postJson(client, "/v1/frames", smallFrame()), 504);
    EXPECT_GE(millisecondsSince(start), 1900.0);
    hold.reset();
    ASSERT_TRUE(soon([&] { return server.backend().queue().depth() == 0; }));
    EXPECT_EQ(server.framesDrawn(), before) << "the dropped one was drawn";
    EXPECT_TRUE(soon(isDrawn));
}

// C2 of the failure catalogue.
TEST(Load, FramesOfDisconnectedClientsAreNotDrawn) {
    TestServer server;
    auto client = server.client();
    ASSERT_EQ(postJson(client, "/v1/frames", smallFrame())->status, 200);
    const std::uint64_t before = server.framesDrawn();
    auto hold = server.holdRenderer();
    std::vector<RawClient> clients;
    for (int i = 0; i < 6; ++i) {
        clients.emplace_back(server.server().port());
        clients.back().send(post("/v1/frames", smallFrame()));
    }
    ASSERT_TRUE(soon([&] { return server.backend().queue().depth() == 6; }));
    clients[0].reset();
    clients[1].reset();
    clients[2].halfClose();
    clients.pop_back();
    ASSERT_TRUE(soon([&] { return server.backend().queue().depth() == 2; }));
    hold.reset();
    for (const int i : {3, 4}) {
        EXPECT_EQ(statusOf(clients[static_cast<std::size_t>(i)].answer(60)), 200);
    }
    EXPECT_EQ(statusOf(clients[2].answer(60)), 503) << "a half-closed client receives the status";
    EXPECT_EQ(server.framesDrawn(), before + 2);
    EXPECT_THAT(client.Get("/metrics")->body,
                testing::HasSubstr("clerestory_refusals_total{reason=\"clientLeft\"} 4"));
}

// A frame in progress ends before its next pass once its client has left and other work waits.
TEST(Load, AFrameOfADisconnectedClientMakesWayForTheNext) {
    DrawingGate gate;
    Config config = testConfig();
    config.renderer.beforeDrawing = gate.whenPlanned();
    TestServer server(config);
    server.awaitReady();
    RenderQueue& queue = server.backend().queue();
    const auto askAndLeave = [&](RawClient& client) {
        gate.close();
        client.send(post("/v1/frames", smallFrame()));
        gate.awaitFrame();
        const auto token = queue.runningToken();
        client.halfClose();
        return soon([&] { return token->cancelled(); });
    };

    const std::uint64_t before = server.framesDrawn();
    RawClient alone(server.server().port());
    ASSERT_TRUE(askAndLeave(alone));
    gate.open();
    EXPECT_EQ(statusOf(alone.answer(60)), 200) << "it may still be listening";
    EXPECT_EQ(server.framesDrawn(), before + 1);

    RawClient leaves(server.server().port());
    ASSERT_TRUE(askAndLeave(leaves));
    auto next = std::async(std::launch::async, [&] {
        auto client = server.client();
        return postJson(client, "/v1/frames", pose(1))->status;
    });
    ASSERT_TRUE(soon([&] { return queue.hasWaiting(); }));
    gate.open();
    EXPECT_EQ(statusOf(leaves.answer(60)), 503);
    EXPECT_EQ(next.get(), 200);
    EXPECT_EQ(server.framesDrawn(), before + 2) << "one before, and the next one";
}

// The renderer's thread asks with the queue's lock, which the callback takes, too.
TEST(Load, AskingWhetherAClientLeftDoesNotWaitForTheCallback) {
    CancellationToken token;
    std::future<bool> asked;
    token.onCancel([&] {
        asked = std::async(std::launch::async, [&] { return token.cancelled(); });
        EXPECT_EQ(asked.wait_for(std::chrono::seconds(60)), std::future_status::ready);
    });
    token.cancel();
    EXPECT_TRUE(asked.get());
}

TEST(Load, AClientMaySetADeadline) {
    TestServer server;
    auto client = server.client();
    ASSERT_EQ(postJson(client, "/v1/frames", smallFrame())->status, 200);
    const std::uint64_t before = server.framesDrawn();
    {
        auto hold = server.holdRenderer();
        const httplib::Headers soonEnough = {{"Clerestory-Deadline", "300"}};
        problemOf(client.Post("/v1/frames", soonEnough, smallFrame(), "application/json"), 504);
        EXPECT_EQ(server.backend().queue().depth(), 0u) << "the queue is empty";
    }
    EXPECT_EQ(server.framesDrawn(), before);
    for (const char* wrong : {"soon", "-1", "0", "1.5", "99999999999999999999"}) {
        const httplib::Headers headers = {{"Clerestory-Deadline", wrong}};
        problemOf(client.Post("/v1/frames", headers, smallFrame(), "application/json"), 400);
    }
}

TEST(Load, StoppingCompletesRunningFramesAndRejectsTheRest) {
    TestServer server;
    auto client = server.client();
    ASSERT_EQ(postJson(client, "/v1/frames", smallFrame())->status, 200);
    auto hold = server.holdRenderer();
    std::vector<int> statuses(8);
    std::vector<std::thread> waiting;
    for (int& status : statuses) {
        waiting.emplace_back([&] {
            auto own = server.client();
            const auto result = postJson(own, "/v1/frames", smallFrame());
            status = result ? result->status : 0;
        });
    }
    ASSERT_TRUE(soon([&] { return server.backend().queue().depth() == statuses.size(); }));
    std::thread stopping([&] { server.stop(); });
    // Asked before the stop took hold, a client would wait behind the hold: it gives up and asks
    // again.
    client.set_read_timeout(0, 200'000);
    httplib::Result refused{nullptr, httplib::Error::Unknown};
    ASSERT_TRUE(soon([&] {
        refused = postJson(client, "/v1/frames", smallFrame());
        return refused && refused->status == 503;
    }));
    problemOf(refused, 503);
    EXPECT_TRUE(refused->has_header("Retry-After"));
    hold.reset();
    for (std::thread& thread : waiting) thread.join();
    stopping.join();
    EXPECT_EQ(statuses, std::vector<int>(8, 200));
    EXPECT_FALSE(server.client().Get("/healthz")) << "the port is closed";
}

TEST(Load, AUsedPortPrintsOneLine) {
    Config config = testConfig();
    config.http.port = sharedServer().server().port();
    try {
        TestServer second(config);
        FAIL() << "two servers on one port";
    } catch (const std::runtime_error& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr("cannot listen on 127.0.0.1"));
    }
}

// R3. An accuracy that no other test uses, so that none of its maps is resident.
TEST(Load, TheLeastTimeOfASampleBoundsThatOfAFrame) {
    SamplePrice price;
    EXPECT_EQ(price.leastSeconds(1'000'000), 0.0) << "nothing is known";
    price.update(1000, 1e-9);
    EXPECT_EQ(price.leastSeconds(1'000'000), 0.0) << "too few samples say nothing";
    price.update(1'000'000, 0.5);
    price.update(1'000'000, 0.2);
    price.update(1'000'000, 3.0);
    EXPECT_DOUBLE_EQ(price.leastSeconds(10'000'000), 2.0);
}

// A3 of the catalogue of attacks.
TEST(Load, AFrameThatCannotMeetItsDeadlineIsRefusedBeforeItIsDrawn) {
    TestServer server;
    server.awaitReady();
    auto client = server.client();
    const std::string large = R"({"scene": "six-walls", "width": 2048, "height": 1280,
        "accuracy": {"preset": "fine"}})";
    // The server knows that frame to take at least as long as its surfaces, on any machine.
    double surfaces = 1e9;         // milliseconds
    for (int i = 0; i < 3; ++i) {  // the first one makes what the others need
        const auto frame =
            client.Post("/v1/frames", {{"Prefer", "wait=60"}}, large, "application/json");
        ASSERT_EQ(frame->status, 200);
        const std::string timing = frame->get_header_value("Server-Timing"), name = "surface;dur=";
        surfaces = std::min(surfaces, std::stod(timing.substr(timing.find(name) + name.size())));
    }
    const httplib::Headers deadline = {
        {"Clerestory-Deadline", std::to_string(std::max(static_cast<int>(surfaces / 2.0), 1))}};
    const std::uint64_t before = server.framesDrawn();
    // While the renderer is at work the deadline may pass in the queue (504), or be known to pass
    // there (503): asked again.
    EXPECT_TRUE(soon([&] {
        const auto answer = client.Post("/v1/frames", deadline, large, "application/json");
        const json problem = problemOf(answer, answer->status == 503 ? 503 : 504);
        return problem.at("detail").get<std::string>().find("at least") != std::string::npos;
    }));
    EXPECT_EQ(server.framesDrawn(), before);
    EXPECT_EQ(postJson(client, "/v1/frames", smallFrame())->status, 200);
}

// A first frame makes maps, targets and programs, which says nothing about other frames: of the
// chapel at `fine`, 15.6 s were predicted after one at `standard`, and it took 4.7 s.
TEST(Load, AFirstFrameIsNoBoundForOthers) {
    TestServer server;
    server.awaitReady();
    auto client = server.client();
    const auto frameOf = [&](int width, const httplib::Headers& headers) {
        const std::string body = R"({"scene": "six-walls", "height": 720, "accuracy": "fine",
            "width": )" + std::to_string(width) +
                                 "}";
        return client.Post("/v1/frames", headers, body, "application/json");
    };
    ASSERT_EQ(frameOf(1280, {{"Prefer", "wait=60"}})->status, 200);
    for (const int milliseconds : {10, 30, 100}) {
        const auto frame =
            frameOf(1280 - milliseconds, {{"Clerestory-Deadline", std::to_string(milliseconds)}});
        ASSERT_TRUE(frame);
        EXPECT_EQ(frame->body.find("would take at least"), std::string::npos) << milliseconds;
    }
}

TEST(Work, TheSampleLimitIsExact) {
    const std::string body = smallFrame(R"("accuracy": {"environmentSize": 48, "samples": 2})");
    auto planClient = sharedServer().client();
    const json plan = json::parse(postJson(planClient, "/v1/plans", body)->body);
    const auto samples = plan.at("totals").at("samples").get<std::uint64_t>();
    Config config = testConfig();
    config.renderer.maxShadedSamples = samples;
    {
        TestServer server(config);
        auto client = server.client();
        EXPECT_EQ(postJson(client, "/v1/frames", body)->status, 200);
    }
    config.renderer.maxShadedSamples = samples - 1;
    TestServer server(config);
    server.awaitReady();
    auto client = server.client();
    const json problem = problemOf(postJson(client, "/v1/frames", body), 422);
    std::set<std::string> pointers;
    for (const json& error : problem.at("errors")) {
        pointers.insert(error.at("pointer"));
        EXPECT_THAT(error.at("allowed").get<std::string>(),
                    testing::HasSubstr(std::to_string(samples - 1)));
    }
    for (const char* knob : {"/width", "/accuracy/environmentSize", "/accuracy/samples"}) {
        EXPECT_TRUE(pointers.contains(knob)) << knob;
    }
    // Refused before anything is made for it: by its size, and by its plan.
    const auto texturesMade = [&] {
        return server.backend().queue().run(std::chrono::seconds(60),
                                            [](Renderer& r) { return r.counters().texturesMade; });
    };
    const std::uint64_t before = texturesMade();
    for (int i = 0; i < 20; ++i) {
        problemOf(postJson(client, "/v1/frames",
                           R"({"scene": "six-walls", "width": 4096, "height": 2160})"),
                  422);
        problemOf(
            postJson(client, "/v1/frames", smallFrame(R"("accuracy": {"environmentSize": 1024})")),
            422);
    }
    EXPECT_EQ(texturesMade(), before);
    EXPECT_EQ(postJson(client, "/v1/frames", R"({"scene": "six-walls", "width": 8, "height": 8})")
                  ->status,
              200);
}

}  // namespace
}  // namespace clerestory::test
