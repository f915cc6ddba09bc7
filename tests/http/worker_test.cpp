// The renderer in a separate process: the same bytes, and nothing lost when it ends.
#include "scene/import/sandbox/jail.h"
#include "tests/support/test_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <mutex>
#include <set>
#include <thread>

#include <sys/wait.h>

namespace clerestory::test {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;

Config workerConfig() {
    Config config = testConfig();
    config.singleProcess = false;
    config.workers.program.file = CLERESTORY_PROGRAM;
    config.workers.program.arguments = {"--scene",    "six-walls", "--log-level",     "off",
                                        "--queue",    "256",       "--queue-seconds", "60",
                                        "--deadline", "60"};
    return config;
}

class WorkerServer : public testing::Test {
protected:
    void SetUp() override { server.start(); }
    httplib::Client client() { return clientOf(server); }
    pid_t worker() { return supervisorOf(server).processes().first; }
    Server server{workerConfig()};
};

std::string frameBody(int i) {
    return smallFrame(R"("camera": {"position": [)" + std::to_string(0.01 * i) +
                      R"(, 1, 2], "target": [0, 1, 0]})");
}

TEST_F(WorkerServer, GivesTheBytesOfASingleProcess) {
    auto there = client();
    auto here = sharedServer().client();
    for (const std::string& body :
         {smallFrame(), smallFrame(R"("output": {"format": "npy", "channel": "depth"})"),
          smallFrame(R"("accuracy": "fine", "output": {"format": "png"})")}) {
        const auto a = postJson(there, "/v1/frames", body), b = postJson(here, "/v1/frames", body);
        ASSERT_EQ(a->status, 200) << a->body;
        EXPECT_EQ(a->body, b->body);
        // The tag is over the program too, which here is another one.
        EXPECT_EQ(a->get_header_value("ETag").size(), b->get_header_value("ETag").size());
        EXPECT_EQ(a->get_header_value("Clerestory-Passes"),
                  b->get_header_value("Clerestory-Passes"));
    }
    // The reported state of shaders is equal once all are compiled.
    while (there.Get("/readyz")->status != 200) {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    sharedServer().awaitReady();
    for (const char* path : {"/v1/scenes", "/v1/scenes/six-walls", "/openapi.json"}) {
        EXPECT_EQ(there.Get(path)->body, here.Get(path)->body) << path;
    }
    for (const char* body : {"{", R"({"width": 0, "widht": 3})", R"({"scene": "unknown"})"}) {
        const auto a = postJson(there, "/v1/frames", body), b = postJson(here, "/v1/frames", body);
        EXPECT_EQ(a->status, b->status);
        const json one = json::parse(a->body), other = json::parse(b->body);
        EXPECT_EQ(one.value("errors", json()), other.value("errors", json()));
        EXPECT_EQ(one.at("detail"), other.at("detail"));
    }
    EXPECT_EQ(there.Get("/nothing")->status, 404);
    EXPECT_EQ(there.Get("/v1/plans")->status, 405);
    EXPECT_EQ(there.Get("/healthz")->status, 200);
    EXPECT_EQ(there.Get("/readyz")->status, 200);
    const std::string metrics = there.Get("/metrics")->body;
    EXPECT_THAT(metrics, testing::HasSubstr("clerestory_passes_total"));
    EXPECT_THAT(metrics, testing::HasSubstr("clerestory_workers{role=\"active\"} 1"));
}

TEST_F(WorkerServer, ReportsItsConfinement) {
    if (kSanitized) GTEST_SKIP() << "a sanitizer makes other system calls";
    auto client = this->client();
    const json renderer = json::parse(client.Get("/v1/renderer")->body);
    const JailSupport kernel = jailSupport();
    for (const char* process : {"importer", "confinement"}) {
        EXPECT_EQ(renderer[process]["landlock"], kernel.landlock) << process;
        EXPECT_EQ(renderer[process]["systemCallFilter"], kernel.systemCallFilter) << process;
    }
}

TEST_F(WorkerServer, ClientDeadlinesAreForwarded) {
    auto client = this->client();
    // Shaders are already compiled here.
    ASSERT_EQ(postJson(client, "/v1/frames", smallFrame(R"("accuracy": {"samples": 8})"))->status,
              200);
    while (client.Get("/readyz")->status != 200) {
    }
    const httplib::Headers headers = {{"Clerestory-Deadline", "1"}};
    problemOf(
        client.Post("/v1/frames", headers, smallFrame(R"("accuracy": {"samples": 8}, "time": 1)"),
                    "application/json"),
        504);
}

TEST_F(WorkerServer, KillsDuringAFrameLoseNothing) {
    auto calm = client();
    std::vector<std::string> expected;
    for (int i = 0; i < 8; ++i) {
        expected.push_back(postJson(calm, "/v1/frames", frameBody(i))->body);
    }
    std::atomic<bool> ending{false};
    std::atomic<int> right{0}, wrong{0};
    std::vector<std::thread> clients;
    for (int c = 0; c < 4; ++c) {
        clients.emplace_back([&, c] {
            auto own = client();
            for (int n = c; !ending; n = (n + 3) % 8) {
                const auto result = postJson(own, "/v1/frames", frameBody(n));
                if (result && result->status == 200 && result->body == expected[n]) {
                    ++right;
                } else if (++wrong == 1) {
                    ADD_FAILURE() << (result ? std::to_string(result->status) + " " + result->body
                                             : httplib::to_string(result.error()));
                }
            }
        });
    }
    constexpr int kKills = 6;
    for (int i = 0; i < kKills; ++i) {
        awaitStandby(server);
        const pid_t victim = worker();
        const int before = right;
        kill(victim, SIGKILL);
        for (int n = 0; n < 3000 && (worker() == victim || right < before + 2); ++n) {
            std::this_thread::sleep_for(10ms);
        }
    }
    ending = true;
    for (std::thread& one : clients) one.join();
    EXPECT_EQ(wrong, 0);
    EXPECT_GT(right, kKills);
    EXPECT_GE(supervisorOf(server).counters().ended, static_cast<std::uint64_t>(kKills));
}

// The frame cache is in the server's process, so that it outlives a renderer; it is used as long as
// the next one holds the same scene.
TEST(FrameCacheOfWorkers, AnswersThroughTheEndOfARenderer) {
    Config config = workerConfig();
    config.frameCacheBytes = 64 << 20;
    Server server(config);
    server.start();
    auto client = clientOf(server);
    while (client.Get("/readyz")->status != 200) std::this_thread::sleep_for(20ms);
    const auto drawn = postJson(client, "/v1/frames", smallFrame());
    auto hit = postJson(client, "/v1/frames", smallFrame());
    for (int i = 0; i < 500 && !hit->has_header("Age"); ++i) {  // the renderer was not warm
        std::this_thread::sleep_for(20ms);
        hit = postJson(client, "/v1/frames", smallFrame());
    }
    ASSERT_TRUE(hit->has_header("Age"));
    EXPECT_EQ(hit->body, drawn->body);
    EXPECT_EQ(hit->get_header_value("Clerestory-Worker"), "1");
    awaitStandby(server);
    while (!supervisorOf(server).standbyIsWarm()) std::this_thread::sleep_for(20ms);
    killWorker(server);
    const auto after = postJson(client, "/v1/frames", smallFrame());
    EXPECT_TRUE(after->has_header("Age"));
    EXPECT_EQ(after->body, drawn->body);
    const auto other = postJson(client, "/v1/frames", frameBody(1));
    EXPECT_EQ(other->status, 200) << other->body;
    EXPECT_FALSE(other->has_header("Age"));
    EXPECT_EQ(other->get_header_value("Clerestory-Worker"), "2");
}

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
        for (int i = 0; !bothHold(); ++i) {
            ASSERT_LT(i, 2400) << "the second renderer does not follow";
            std::this_thread::sleep_for(50ms);
        }
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
        for (int n = 0; n < 3000; ++n) {
            const auto active = supervisorOf(server).activeProcesses();
            if (std::find(active.begin(), active.end(), victim) == active.end()) break;
            std::this_thread::sleep_for(10ms);
        }
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
    auto answer = postJson(client, "/v1/frames", body);
    for (; answer->status == 409; answer = postJson(client, "/v1/frames", body)) {
        std::this_thread::sleep_for(20ms);
    }
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
    for (int i = 0; i < 6000; ++i) {
        const json state = json::parse(client.Get(place)->body)["state"];
        ASSERT_NE(state, "failed");
        if (state == "done") return;
        std::this_thread::sleep_for(10ms);
    }
    ADD_FAILURE() << "the job does not end";
}

// S4: of which load of its scene a frame is, and whose.
TEST_F(WorkerServer, AFrameNamesItsRendererAndSceneGeneration) {
    auto client = this->client();
    const auto drawn = [&](const std::string& body) {
        auto answer = postJson(client, "/v1/frames", body);
        for (int i = 0; i < 600 && answer && answer->status == 409; ++i) {  // its scene loads
            std::this_thread::sleep_for(50ms);
            answer = postJson(client, "/v1/frames", body);
        }
        EXPECT_EQ(answer->status, 200) << answer->body;
        return std::pair(answer->get_header_value("Clerestory-Worker"),
                         std::stoi("0" + answer->get_header_value("Clerestory-Scene-Generation")));
    };
    const auto first = drawn(smallFrame());
    EXPECT_EQ(first.first, "1");
    EXPECT_GT(first.second, 0);
    EXPECT_EQ(drawn(frameBody(1)), first) << "the same scene, from the same load";
    const auto other = drawn(R"({"scene": "meadow", "width": 16, "height": 16})");
    EXPECT_EQ(other.first, "1");
    EXPECT_GT(other.second, first.second);
    awaitStandby(server);
    kill(worker(), SIGKILL);
    EXPECT_NE(drawn(smallFrame()).first, "1") << "another renderer, another number";
}

class SharedScenes : public WorkerServer {
protected:
    using Counts = std::pair<std::size_t, std::size_t>;
    const std::string kBody =
        R"({"scene": "orbiting-cubes", "width": 64, "height": 48, "output": {"format": "png"}, )" +
        kPlainEffects + "}";

    std::string loaded() {
        auto client = this->client();
        auto answer = postJson(client, "/v1/frames", kBody);
        for (; answer->status == 409; answer = postJson(client, "/v1/frames", kBody)) {
            std::this_thread::sleep_for(20ms);
        }
        EXPECT_EQ(answer->status, 200) << answer->body;
        return answer->body;
    }
    void awaitScenes(const Counts& wanted) {
        for (int i = 0; supervisorOf(server).scenes() != wanted; ++i) {
            ASSERT_LT(i, 600) << "the standby does not follow";
            std::this_thread::sleep_for(50ms);
        }
        EXPECT_TRUE(supervisorOf(server).standbyIsWarm());
    }
};

// A scene that was requested once is available after a kill, without a loading state.
TEST_F(SharedScenes, TheNextRendererHasThem) {
    const std::string first = loaded();
    auto client = this->client();
    for (int kills = 0; kills < 3; ++kills) {
        ASSERT_NO_FATAL_FAILURE(awaitScenes({2, 2}));
        const pid_t before = worker();
        ::kill(before, SIGKILL);
        const auto after = postJson(client, "/v1/frames", kBody);
        EXPECT_EQ(after->status, 200) << after->body;
        EXPECT_EQ(after->body, first);
        EXPECT_NE(worker(), before);
    }
    EXPECT_THAT(client.Get("/metrics")->body,
                testing::HasSubstr("clerestory_worker_scenes{role=\"active\"} 2"));
}

// The scenes may have been more than it had room for.
TEST_F(SharedScenes, AFailedStandbyIsReplacedByOneWithoutScenes) {
    loaded();
    ASSERT_NO_FATAL_FAILURE(awaitScenes({2, 2}));
    const pid_t standby = supervisorOf(server).processes().second;
    ::kill(standby, SIGKILL);
    while (supervisorOf(server).processes().second == standby) std::this_thread::sleep_for(20ms);
    ASSERT_NO_FATAL_FAILURE(awaitScenes({2, 1}));
    std::this_thread::sleep_for(1500ms);
    EXPECT_EQ(supervisorOf(server).scenes(), Counts(2, 1)) << "and stays so";
    killWorker(server);
    loaded();
    awaitScenes({2, 2});
}

TEST_F(WorkerServer, AJobRestartsWhenItsRendererEnds) {
    auto client = this->client();
    awaitStandby(server);
    const auto started =
        postJson(client, "/v1/comparisons",
                 smallFrame(R"("frames": 2, "samples": 64, "settings": ["draft"])"));
    ASSERT_TRUE(started);
    ASSERT_EQ(started->status, 202) << started->body;
    const std::string place = started->get_header_value("Location");
    kill(worker(), SIGKILL);
    json job;
    for (int i = 0; i < 6000; ++i) {
        const auto answer = client.Get(place);
        ASSERT_TRUE(answer);
        ASSERT_EQ(answer->status, 200) << answer->body;
        job = json::parse(answer->body);
        ASSERT_NE(job["state"], "failed") << job;
        if (job["state"] == "done") break;
        std::this_thread::sleep_for(10ms);
    }
    EXPECT_EQ(job["state"], "done") << job;
    EXPECT_EQ(place, "/v1/jobs/" + job.value("id", ""));
    EXPECT_EQ(job["result"]["settings"].size(), 1u);
}

TEST_F(WorkerServer, ASequenceContinuesAfterAKill) {
    awaitStandby(server);
    json frames = json::array();
    for (int i = 0; i < 30; ++i) frames.push_back(json::parse(frameBody(i)));
    std::string got;
    std::thread reader([&] {
        auto own = client();
        got = own.Post("/v1/sequences", {{"Accept", "multipart/mixed"}},
                       json{{"frames", frames}}.dump(), "application/json")
                  ->body;
    });
    std::this_thread::sleep_for(50ms);
    kill(worker(), SIGKILL);
    reader.join();
    const std::size_t manifest = got.find("manifest.json");
    ASSERT_NE(manifest, std::string::npos);
    EXPECT_NE(got.find("\"failures\": 0", manifest), std::string::npos);
}

TEST_F(WorkerServer, WorkersEndWithTheirServer) {
    pid_t first = 0, second = 0;
    {
        Server other(workerConfig());
        for (int i = 0; i < 3000 && second == 0; ++i) {
            std::this_thread::sleep_for(10ms);
            std::tie(first, second) = supervisorOf(other).processes();
        }
        ASSERT_EQ(kill(first, 0), 0);
        ASSERT_EQ(kill(second, 0), 0);
    }
    EXPECT_NE(kill(first, 0), 0);
    EXPECT_NE(kill(second, 0), 0);
}

TEST(WorkerLimits, AWorkerOutOfMemoryFailsCleanly) {
    if (kSanitized) GTEST_SKIP() << "sanitizers reserve terabytes of address space";
    Config config = workerConfig();
    config.workers.program.arguments.insert(config.workers.program.arguments.end(),
                                            {"--worker-memory", "200MB"});
    EXPECT_THROW(Server server(config), std::runtime_error);
}

}  // namespace
}  // namespace clerestory::test
