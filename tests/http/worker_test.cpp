// The renderer in a separate process: the same bytes, and nothing lost when it ends.
#include "scene/import/sandbox/jail.h"
#include "server/worker/supervisor.h"
#include "tests/support/soon.h"
#include "tests/support/test_server.h"
#include "worker_support.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <future>
#include <thread>

namespace clerestory::test {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;

class WorkerServer : public testing::Test {
protected:
    void SetUp() override { server.start(); }
    httplib::Client client() { return clientOf(server); }
    pid_t worker() { return supervisorOf(server).processes().first; }
    Server server{workerConfig()};
};

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
    ASSERT_TRUE(within(kPatience, [&] { return there.Get("/readyz")->status == 200; }));
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
        EXPECT_TRUE(within(30s, [&] { return worker() != victim && right >= before + 2; }));
    }
    ending = true;
    for (std::thread& one : clients) one.join();
    EXPECT_EQ(wrong, 0);
    EXPECT_GT(right, kKills);
    EXPECT_GE(supervisorOf(server).counters().ended, static_cast<std::uint64_t>(kKills));
}

// A scene whose light ends its renderers would end the next ones, too.
TEST(BackgroundWorkOfWorkers, IsLeftOutAfterItEndedRenderers) {
    Config config = workerConfig();
    config.workers.standby = false;
    config.workers.program.arguments = {"--scene", "teapots",     "--scene-cache",
                                        "none",    "--log-level", "off"};
    Server server(config);
    server.start();
    auto client = clientOf(server);
    std::string light;
    int killed = 0;
    const auto failed = [&] {
        // Each has a light of its own, which takes seconds.
        const std::string body = R"({"width": 64, "height": 48, "environment": {"intensity": )" +
                                 std::to_string(1.0 + 0.01 * killed) + "}}";
        postJson(client, "/v1/frames", body);  // begins it
        const auto frame = postJson(client, "/v1/frames", body);
        if (!frame || frame->status != 200) return false;
        light = frame->get_header_value("Clerestory-Light");
        if (light.ends_with("failed")) return true;
        ::kill(supervisorOf(server).processes().first, SIGKILL);
        return ++killed > 50;
    };
    ASSERT_TRUE(within(kPatience, failed)) << light;
    EXPECT_EQ(light, "revision=0, share=0.00, failed");
    EXPECT_GE(killed, EndedWork::kMaxEnds);
    const json scene = json::parse(client.Get("/v1/scenes/teapots")->body);
    EXPECT_EQ(scene.at("light").value("failed", false), true) << scene.at("light");
}

// The frame cache is in the server's process, so that it outlives a renderer; it is used as long as
// the next one holds the same scene.
TEST(FrameCacheOfWorkers, AnswersThroughTheEndOfARenderer) {
    Config config = workerConfig();
    config.frameCacheBytes = 64 << 20;
    Server server(config);
    server.start();
    auto client = clientOf(server);
    ASSERT_TRUE(within(kPatience, [&] { return client.Get("/readyz")->status == 200; }));
    const auto drawn = postJson(client, "/v1/frames", smallFrame());
    auto hit = postJson(client, "/v1/frames", smallFrame());
    ASSERT_TRUE(soon([&] {  // the renderer was not warm
        if (!hit->has_header("Age")) hit = postJson(client, "/v1/frames", smallFrame());
        return hit->has_header("Age");
    }));
    EXPECT_EQ(hit->body, drawn->body);
    EXPECT_EQ(hit->get_header_value("Clerestory-Worker"), "1");
    awaitStandby(server);
    ASSERT_TRUE(within(kPatience, [&] { return supervisorOf(server).standbyIsWarm(); }));
    killWorker(server);
    const auto after = postJson(client, "/v1/frames", smallFrame());
    EXPECT_TRUE(after->has_header("Age"));
    EXPECT_EQ(after->body, drawn->body);
    const auto other = postJson(client, "/v1/frames", frameBody(1));
    EXPECT_EQ(other->status, 200) << other->body;
    EXPECT_FALSE(other->has_header("Age"));
    EXPECT_EQ(other->get_header_value("Clerestory-Worker"), "2");
}

// S4: of which load of its scene a frame is, and whose.
TEST_F(WorkerServer, AFrameNamesItsRendererAndSceneGeneration) {
    auto client = this->client();
    const auto drawn = [&](const std::string& body) {
        const auto answer = postUntilReady(client, "/v1/frames", body);
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
        const auto answer = postUntilReady(client, "/v1/frames", kBody);
        EXPECT_EQ(answer->status, 200) << answer->body;
        return answer->body;
    }
    void awaitScenes(const Counts& wanted) {
        ASSERT_TRUE(within(30s, [&] { return supervisorOf(server).scenes() == wanted; }))
            << "the standby does not follow";
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
    ASSERT_TRUE(
        within(kPatience, [&] { return supervisorOf(server).processes().second != standby; }));
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
    within(60s, [&] {
        const auto answer = client.Get(place);
        EXPECT_TRUE(answer && answer->status == 200);
        job = answer ? json::parse(answer->body) : json::object();
        const std::string state = job.value("state", "");
        return state != "queued" && state != "running";
    });
    EXPECT_EQ(job["state"], "done") << job;
    EXPECT_EQ(place, "/v1/jobs/" + job.value("id", ""));
    EXPECT_EQ(job["result"]["settings"].size(), 1u);
}

TEST_F(WorkerServer, ASequenceContinuesAfterAKill) {
    awaitStandby(server);
    json frames = json::array();
    for (int i = 0; i < 30; ++i) frames.push_back(json::parse(frameBody(i)));
    std::string got;
    std::promise<void> begun;
    std::thread reader([&] {
        auto own = client();
        httplib::Request request;
        request.method = "POST";
        request.path = "/v1/sequences";
        request.headers = {{"Accept", "multipart/mixed"}, {"Content-Type", "application/json"}};
        request.body = json{{"frames", frames}}.dump();
        request.content_receiver = [&](const char* data, std::size_t size, std::uint64_t,
                                       std::uint64_t) {
            if (got.empty()) begun.set_value();
            got.append(data, size);
            return true;
        };
        EXPECT_TRUE(own.send(request));
    });
    begun.get_future().wait();
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
        ASSERT_TRUE(within(30s, [&] {
            std::tie(first, second) = supervisorOf(other).processes();
            return second != 0;
        }));
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
