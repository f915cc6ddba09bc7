// Several renderers in processes of their own: one server, the same bytes.
#include "tests/support/soon.h"
#include "worker_support.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <mutex>
#include <set>
#include <thread>

namespace clerestory::test {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;

class SeveralRenderers : public testing::Test {
protected:
    static Config severalConfig() {
        Config config = workerConfig();
        config.workers.renderers = 2;
        config.workers.program.arguments.insert(config.workers.program.arguments.end(),
                                                {"--renderers", "2"});
        return config;
    }
    void SetUp() override {
        server.start();
        awaitBoth(1);
    }
    httplib::Client client() { return clientOf(server); }
    // Until both renderers are warm and hold that many scenes.
    void awaitBoth(std::size_t scenes) {
        const auto bothHold = [&] {
            const auto states = supervisorOf(server).renderers();
            return std::all_of(states.begin(), states.end(), [&](const RendererState& state) {
                return state.loaded && state.loaded->scenes.size() == scenes;
            });
        };
        ASSERT_TRUE(within(120s, bothHold)) << "the second renderer does not follow";
    }
    // Eight clients request frames 0 to 7 at the same time, each as often as `rounds`. Returns the
    // renderers that drew them.
    std::set<std::string> drawAll(int rounds, const std::vector<std::string>& expected) {
        std::set<std::string> drew;
        std::mutex mutex;
        std::vector<std::thread> clients;
        for (int c = 0; c < 8; ++c) {
            clients.emplace_back([&, c] {
                auto own = client();
                for (int n = 0; n < rounds; ++n) {
                    const auto i = static_cast<std::size_t>((c + n) % 8);
                    const auto answer = postJson(own, "/v1/frames", frameBody(static_cast<int>(i)));
                    const std::lock_guard lock(mutex);
                    EXPECT_EQ(answer->status, 200) << answer->body;
                    EXPECT_EQ(answer->body, expected[i]) << i;
                    drew.insert(answer->get_header_value("Clerestory-Worker"));
                }
            });
        }
        for (std::thread& one : clients) one.join();
        return drew;
    }
    static std::vector<std::string> framesOfOneProcess() {
        auto here = sharedServer().client();
        std::vector<std::string> frames;
        for (int i = 0; i < 8; ++i) {
            frames.push_back(postJson(here, "/v1/frames", frameBody(i))->body);
        }
        return frames;
    }
    Server server{severalConfig()};
};

TEST_F(SeveralRenderers, ShareTheFramesAndGiveTheBytesOfOne) {
    const std::set<std::string> drew = drawAll(6, framesOfOneProcess());
    EXPECT_EQ(drew, (std::set<std::string>{"1", "2"}));
    auto client = this->client();
    EXPECT_EQ(client.Get("/readyz")->status, 200);
    const json renderers = json::parse(client.Get("/v1/renderer")->body)["renderers"];
    EXPECT_EQ(renderers, json::parse(R"([{"worker": 1, "warm": true, "scenes": 1},
                                         {"worker": 2, "warm": true, "scenes": 1}])"));
    const std::string metrics = client.Get("/metrics")->body;
    for (const char* line :
         {"clerestory_workers{role=\"active\"} 2", "clerestory_workers{role=\"warm\"} 2",
          "clerestory_held{pool=\"queueEntries\"} 0",
          "clerestory_frame_seconds_count{renderer=\"1\"} ",
          "clerestory_frame_seconds_count{renderer=\"2\"} "}) {
        EXPECT_THAT(metrics, testing::HasSubstr(line));
    }
    const auto drawnBy = [&](const char* renderer) {
        const std::string name =
            std::string("clerestory_frame_seconds_count{renderer=\"") + renderer + "\"} ";
        return std::stoi(metrics.substr(metrics.find(name) + name.size()));
    };
    EXPECT_EQ(drawnBy("1") + drawnBy("2"), 48);
    // Requests that are not frames, and wrong ones.
    EXPECT_EQ(postJson(client, "/v1/plans", smallFrame())->status, 200);
    problemOf(postJson(client, "/v1/frames", R"({"widht": 3})"), 422);
    problemOf(postJson(client, "/v1/frames", R"({"scene": "unknown"})"), 404);
    problemOf(client.Get("/v1/plans"), 405);
    const std::string link = "/v1/frames?width=64&height=48" + kPlainLink;
    const std::string etag = client.Get(link)->get_header_value("ETag");
    EXPECT_EQ(client.Get(link, unless(etag))->status, 304);
    EXPECT_THAT(
        client.Get("/metrics")->body,
        testing::HasSubstr("clerestory_requests_total{route=\"/v1/frames\",status=\"422\"}"));
}

TEST_F(SeveralRenderers, KillsDuringFramesLoseNothing) {
    const std::vector<std::string> expected = framesOfOneProcess();
    std::atomic<bool> ending{false};
    std::thread clients([&] {
        while (!ending) drawAll(2, expected);
    });
    for (std::size_t i = 0; i < 6; ++i) {
        awaitStandby(server);
        const pid_t victim = supervisorOf(server).activeProcesses()[i % 2];
        kill(victim, SIGKILL);
        EXPECT_TRUE(within(30s, [&] {
            const auto active = supervisorOf(server).activeProcesses();
            return std::find(active.begin(), active.end(), victim) == active.end();
        }));
    }
    ending = true;
    clients.join();
    EXPECT_GE(supervisorOf(server).counters().ended, 6u);
    awaitBoth(1);
    EXPECT_EQ(drawAll(6, expected).size(), 2u) << "again two";
}

TEST_F(SeveralRenderers, DrawTheFramesOfASequenceInTurn) {
    const std::vector<std::string> expected = framesOfOneProcess();
    json frames = json::array();
    for (int i = 0; i < 8; ++i) frames.push_back(json::parse(frameBody(i)));
    auto client = this->client();
    const auto answer = client.Post("/v1/sequences", {{"Accept", "multipart/mixed"}},
                                    json{{"frames", frames}}.dump(), "application/json");
    ASSERT_EQ(answer->status, 200);
    std::size_t at = 0;
    for (const std::string& frame : expected) {
        at = answer->body.find(frame, at);
        ASSERT_NE(at, std::string::npos) << "in the order of the request";
        at += frame.size();
    }
    EXPECT_THAT(answer->body, testing::HasSubstr("\"failures\": 0"));
    const std::string metrics = client.Get("/metrics")->body;
    for (const char* renderer : {"1", "2"}) {
        const std::string name =
            std::string("clerestory_frame_seconds_count{renderer=\"") + renderer + "\"} ";
        EXPECT_GT(std::stoi(metrics.substr(metrics.find(name) + name.size())), 0) << renderer;
    }
}

// A scene that is requested for the first time is loaded by one renderer, and then by the other.
TEST_F(SeveralRenderers, LoadTheSameScenes) {
    const std::string body =
        R"({"scene": "orbiting-cubes", "width": 64, "height": 48, )" + kPlainEffects + "}";
    auto client = this->client();
    const auto answer = postUntilReady(client, "/v1/frames", body);
    ASSERT_EQ(answer->status, 200) << answer->body;
    for (int i = 0; i < 8; ++i) {
        EXPECT_EQ(postJson(client, "/v1/frames", body)->status, 200) << "loaded by one at least";
    }
    ASSERT_NO_FATAL_FAILURE(awaitBoth(2));
    EXPECT_EQ(postJson(client, "/v1/frames", body)->body, answer->body);
    // Sequences and jobs.
    const json frames = {{"frames", {json::parse(body), json::parse(body)}}};
    const auto sequence = client.Post("/v1/sequences", {{"Accept", "multipart/mixed"}},
                                      frames.dump(), "application/json");
    EXPECT_EQ(sequence->status, 200);
    EXPECT_THAT(sequence->body, testing::HasSubstr("\"failures\": 0"));
    const auto job = postJson(client, "/v1/comparisons",
                              smallFrame(R"("frames": 1, "samples": 2, "settings": ["draft"])"));
    ASSERT_EQ(job->status, 202) << job->body;
    const std::string place = job->get_header_value("Location");
    std::string state;
    EXPECT_TRUE(within(60s, [&] {
        state = json::parse(client.Get(place)->body)["state"];
        return state == "done" || state == "failed";
    })) << "the job does not end";
    EXPECT_EQ(state, "done");
}

}  // namespace
}  // namespace clerestory::test
