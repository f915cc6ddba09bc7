// Uploads when space, memory, disk or renderers are exhausted.
#include "server/base/process.h"
#include "tests/http/uploads_support.h"
#include "tests/support/server_process.h"
#include "tests/support/soon.h"

#include <csignal>
#include <fstream>
#include <map>
#include <mutex>

#include <sys/resource.h>

namespace clerestory::test {
namespace {

using testing::HasSubstr;

TEST(Uploads, AFullStoreReturns507) {
    Config config = uploadConfig();
    config.scenes.uploads.limits.count = 2;
    TestServer server(config);
    auto client = server.client();
    const std::string first = idOf(send(client, triangleGlb(1)));
    EXPECT_EQ(send(client, triangleGlb(2))->status, 201);
    const json problem = problemOf(send(client, triangleGlb(3)), 507);
    EXPECT_THAT(problem["detail"].get<std::string>(), HasSubstr("DELETE"));
    EXPECT_EQ(send(client, triangleGlb(1))->status, 200) << "existing content needs no space";
    EXPECT_EQ(client.Delete("/v1/scenes/" + first)->status, 204);
    EXPECT_EQ(send(client, triangleGlb(3))->status, 201);
}

TEST(Uploads, ReportedSceneMemoryAddsUp) {
    TestServer server(uploadConfig());
    auto client = server.client();
    const std::string id = idOf(send(client, triangleGlb(0, 1000)));
    pictureOf(client, id);
    const json memory = sceneAt(client, id)["memory"];
    // Triangles share no vertex here, so there is an index of 4 bytes for each.
    const bool once = server.backend().queue().identity().readsClientMemory;
    EXPECT_EQ(memory["meshes"], (once ? 1 : 2) * 3000 * (sizeof(Vertex) + 4));
    EXPECT_EQ(memory["textures"], 0);
    EXPECT_EQ(memory["total"].get<std::uint64_t>(),
              memory["meshes"].get<std::uint64_t>() + memory["maps"].get<std::uint64_t>());
    const std::string metrics = client.Get("/metrics")->body;
    for (const char* name :
         {"clerestory_scene_bytes{kind=\"meshes\"}", "clerestory_scenes{state=\"uploaded\"} 1",
          "clerestory_scenes{state=\"loaded\"} 2", "clerestory_scene_evictions 0"}) {
        EXPECT_THAT(metrics, HasSubstr(name));
    }
}

// S4: a frame is of one load of its scene, and every frame that names that load is the same.
class Generations {
public:
    void add(const httplib::Response& frame) {
        const std::lock_guard lock(mutex_);
        const auto [known, isNew] = pictures_.try_emplace(
            frame.get_header_value("Clerestory-Scene-Generation"), frame.body);
        mixed_ += !isNew && known->second != frame.body;
    }
    int mixed() const { return mixed_; }
    std::size_t count() const { return pictures_.size(); }

private:
    std::mutex mutex_;
    std::map<std::string, std::string> pictures_;
    int mixed_ = 0;
};

// Until nothing is being loaded or compiled.
void awaitShaders(SceneLibrary& library) {
    const auto busy = [&](const SceneStatus& scene) {
        return scene.state == SceneState::loading ||
               (scene.state == SceneState::ready && !library.warmUp(scene.id).finished);
    };
    EXPECT_TRUE(within(kPatience, [&] {
        const std::vector<SceneStatus> scenes = library.all();
        return std::none_of(scenes.begin(), scenes.end(), busy);
    }));
}

// 30 swaps; CLERESTORY_SCENE_SWAPS says how many in a long run.
TEST(Uploads, ScenesTakeTurnsInMemoryForTwo) {
    const char* asked = std::getenv("CLERESTORY_SCENE_SWAPS");
    const int swaps = asked ? std::atoi(asked) : 30;
    constexpr unsigned kScenes = 5, kTriangles = 20'000;
    Config config = uploadConfig();
    // Six walls, and two of the others.
    constexpr std::uint64_t kEach = 2 * 3 * kTriangles * (sizeof(Vertex) + 4);
    config.scenes.memoryBytes = 10'000'000 + 2 * kEach;
    TestServer server(config);
    auto client = server.client();
    std::vector<std::string> ids, pictures;
    for (unsigned i = 0; i < kScenes; ++i) {
        const auto made = send(client, triangleGlb(50 * i, kTriangles));
        ASSERT_EQ(made->status, 201) << made->body;
        ids.push_back(idOf(made));
        pictures.push_back(pictureOf(client, ids.back()));
    }
    EXPECT_NE(pictures[0], pictures[4]);
    std::atomic<int> lost{0}, drawn{0};
    Generations generations;
    // Swaps under load on the scene that stays and on those that swap; then the memory at rest.
    const auto allocatedAfter = [&](int first, int last) {
        std::atomic<bool> done{false};
        std::vector<std::thread> others;
        for (int k = 0; k < 3; ++k) {
            others.emplace_back([&, k] {
                auto other = server.client();
                for (std::size_t i = 0; !done; ++i) {
                    const std::string body =
                        k == 0 ? smallFrame() : frameOf(ids[(i / 3 + 2) % kScenes]);
                    const auto answer = postJson(other, "/v1/frames", body);
                    if (answer && answer->status == 200) {
                        ++drawn;
                        generations.add(*answer);
                    } else if (!answer || answer->status != 409) {  // 409: asks again by itself
                        ++lost;
                    }
                }
            });
        }
        for (int i = first; i < last; ++i) {
            const std::size_t which = static_cast<std::size_t>(i) % kScenes;
            EXPECT_EQ(pictureOf(client, ids[which]), pictures[which]) << i;
        }
        done = true;
        for (std::thread& other : others) other.join();
        awaitShaders(server.backend().library());
        return allocatedBytes();
    };
    constexpr int kWarm = 8;
    const double warm = allocatedAfter(0, kWarm), all = allocatedAfter(kWarm, swaps);
    EXPECT_EQ(lost, 0);
    EXPECT_GT(drawn, 0);
    EXPECT_EQ(generations.mixed(), 0);
    EXPECT_GT(generations.count(), 3u) << "scenes were loaded again";
    // What is allocated, not what is resident: the fragments of the heap depend on the threads.
    EXPECT_LT(all - warm, 1.0 * kEach) << "one of the swapped scenes stayed";
    std::printf(
        "%d swaps under %d frames of %zu generations, 0 mixed: %.1f MB after %d, %.1f MB after "
        "all\n",
        swaps, drawn.load(), generations.count(), warm / 1e6, kWarm, all / 1e6);
    const SceneTotals totals = server.backend().library().totals();
    EXPECT_GE(totals.evicted, static_cast<std::uint64_t>(swaps) / 2);
    EXPECT_LE(totals.bytes.total(), config.scenes.memoryBytes);
    EXPECT_EQ(json::parse(client.Get("/v1/scenes/six-walls")->body)["state"], "ready");
}

// Any file that grows beyond 64 KB meets the end of this process's disk.
void endTheDiskSoon() {
    const rlimit most{64 << 10, 64 << 10};
    setrlimit(RLIMIT_FSIZE, &most);
    std::signal(SIGXFSZ, SIG_IGN);  // the write fails instead
}

TEST(Uploads, AFullDiskFailsTheUploadOnly) {
    const fs::path folder = freshFolder();
    const ServerProcess server({"--uploads", (folder / "uploads").string(), "--scene", "six-walls",
                                "--scene-cache", (folder / "cache").string()},
                               endTheDiskSoon);
    ASSERT_TRUE(server.waitUntilReady());
    httplib::Client client("127.0.0.1", server.port());
    client.set_read_timeout(120);
    for (int i = 0; i < 3; ++i) {
        const json problem = problemOf(send(client, triangleGlb(0, 5000)), 507);
        EXPECT_THAT(problem["detail"].get<std::string>(), HasSubstr("full"));
        EXPECT_EQ(kept(folder / "uploads"), 0u) << "nothing is left of it";
        EXPECT_EQ(postJson(client, "/v1/frames", smallFrame())->status, 200);
    }
    // Small enough writes succeed, also for a scene whose blob is too large for the cache.
    const auto made = send(client, triangleGlb());
    ASSERT_TRUE(made);
    EXPECT_EQ(made->status, 201) << made->body;
    EXPECT_FALSE(pictureOf(client, idOf(made)).empty());
}

// Renderers in processes of their own: the folder is all that they have in common.
class UploadsOfWorkers : public testing::Test {
protected:
    void SetUp() override { server.start(); }
    static Config workerConfig() {
        Config config = uploadConfig();
        config.singleProcess = false;
        config.workers.program.file = CLERESTORY_PROGRAM;
        config.workers.program.arguments = {
            "--scene",      "six-walls", "--log-level",      "off",
            "--deadline",   "60",        "--uploads",        config.scenes.uploads.folder.string(),
            "--upload-cpu", "60",        "--upload-seconds", "60"};
        return config;
    }
    httplib::Client client() { return clientOf(server); }
    // Until both renderers have the upload.
    void awaitInStandby(httplib::Client& client, const std::string& id) {
        EXPECT_EQ(postJson(client, "/v1/frames", frameOf(id))->status, 200);
        const Supervisor& supervisor = supervisorOf(server);
        const auto standbyHasIt = [&] {
            const auto [active, standby] = supervisor.scenes();
            return supervisor.standbyIsWarm() && standby == active && active > 1;
        };
        ASSERT_TRUE(within(60s, standbyHasIt));
    }
    Server server{workerConfig()};
};

TEST_F(UploadsOfWorkers, AnUploadThatCrashesRenderersIsAbandoned) {
    auto client = this->client();
    const std::string id = idOf(send(client, triangleGlb()));
    awaitInStandby(client, id);  // a renderer that has loaded it forgets the tries
    // The state after three renderers that began to load it and ended.
    std::ofstream(folderOfThisTest() / id / "tries") << "...";
    killWorker(server);
    json problem;
    for (int i = 0; i < 200 && problem.is_null(); ++i) {
        const auto answer = postJson(client, "/v1/frames", frameOf(id));
        ASSERT_TRUE(answer);
        if (answer->status == 200) {
            killWorker(server);  // a standby that had loaded it before
        } else if (answer->status != 409) {
            problem = problemOf(answer, 422);
        }
    }
    EXPECT_EQ(problem["reason"], "crashed");
    EXPECT_EQ(problemOf(send(client, triangleGlb()), 422)["reason"], "crashed") << "permanently";
    EXPECT_EQ(postJson(client, "/v1/frames", smallFrame())->status, 200);
}

TEST_F(UploadsOfWorkers, SurviveTheirRenderer) {
    auto client = this->client();
    const auto made = send(client, triangleGlb());
    ASSERT_EQ(made->status, 201) << made->body;
    const std::string id = idOf(made), picture = pictureOf(client, id);
    killWorker(server);
    EXPECT_EQ(pictureOf(client, id), picture);
    EXPECT_EQ(send(client, triangleGlb())->status, 200);
    EXPECT_EQ(client.Delete("/v1/scenes/" + id)->status, 204);
    killWorker(server);
    problemOf(postJson(client, "/v1/frames", frameOf(id)), 404);
    EXPECT_THAT(client.Get("/v1/scenes")->body, testing::Not(HasSubstr(id)));
}

// The next renderer has loaded the scene before its deletion, and answers after it.
TEST_F(UploadsOfWorkers, ADeletedSceneDoesNotReturnWithTheNextRenderer) {
    auto client = this->client();
    const std::string id = idOf(send(client, triangleGlb()));
    awaitInStandby(client, id);
    EXPECT_EQ(client.Delete("/v1/scenes/" + id)->status, 204);
    killWorker(server);
    for (int i = 0; i < 3; ++i) problemOf(postJson(client, "/v1/frames", frameOf(id)), 404);
    EXPECT_THAT(client.Get("/v1/scenes")->body, testing::Not(HasSubstr(id)));
}

// Of several renderers.
TEST(UploadsOfSeveralRenderers, AreDeletedInAll) {
    Config config = uploadConfig();
    config.singleProcess = false;
    config.workers.renderers = 2;
    config.workers.standby = false;
    config.workers.program.file = CLERESTORY_PROGRAM;
    config.workers.program.arguments = {"--scene",          "six-walls",
                                        "--log-level",      "off",
                                        "--deadline",       "60",
                                        "--renderers",      "2",
                                        "--uploads",        config.scenes.uploads.folder.string(),
                                        "--upload-cpu",     "60",
                                        "--upload-seconds", "60"};
    Server server(config);
    server.start();
    auto client = clientOf(server);
    const std::string id = idOf(send(client, triangleGlb()));
    const std::string picture = pictureOf(client, id);
    const auto holders = [&] {
        int count = 0;
        for (const RendererState& state : supervisorOf(server).renderers()) {
            count += state.loaded && isLoaded({state}, id);
        }
        return count;
    };
    ASSERT_TRUE(within(120s, [&] { return holders() == 2; }));
    EXPECT_EQ(pictureOf(client, id), picture);
    EXPECT_EQ(client.Delete("/v1/scenes/" + id)->status, 204);
    EXPECT_EQ(holders(), 0);
    for (int i = 0; i < 4; ++i) problemOf(postJson(client, "/v1/frames", frameOf(id)), 404);
}

}  // namespace
}  // namespace clerestory::test
