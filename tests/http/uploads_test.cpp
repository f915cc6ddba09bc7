// Scenes that clients send: from the body to the frame, what is refused and why, what is kept, and
// what happens when renderers end or memory is short.
#include "server/resident.h"
#include "tests/support/raw_client.h"
#include "tests/support/scene_files.h"
#include "tests/support/server_process.h"
#include "tests/support/test_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <thread>

#include <sys/resource.h>

namespace clerestory::test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using nlohmann::json;
using testing::HasSubstr;
using testing::StartsWith;

fs::path folderOfThisTest() {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    return fs::path(CLERESTORY_TEST_OUTPUT) / "uploads" / info->name();
}

fs::path freshFolder() {
    const fs::path folder = folderOfThisTest();
    fs::remove_all(folder);
    fs::create_directories(folder.parent_path());
    return folder;
}

Config uploadConfig() {
    Config config = testConfig();
    config.scenes.uploads.folder = freshFolder();
    config.scenes.uploads.import.cpu = 60s;  // sanitizers are slow
    config.scenes.uploads.import.wallClock = 60s;
    return config;
}

constexpr const char* kAny = "application/octet-stream";

httplib::Result send(httplib::Client& client, const std::string& content, const char* type = kAny,
                     const std::string& query = "") {
    return client.Post("/v1/scenes" + query, content, type);
}

std::string idOf(const httplib::Result& answer) {
    const std::string place = answer->get_header_value("Location");
    EXPECT_THAT(place, StartsWith("/v1/scenes/upload-"));
    return place.substr(place.rfind('/') + 1);
}

std::string frameOf(const std::string& id) {
    return R"({"width": 48, "height": 32, "scene": ")" + id + R"("})";
}

json sceneAt(httplib::Client& client, const std::string& id) {
    const auto answer = client.Get("/v1/scenes/" + id);
    return answer && answer->status == 200 ? json::parse(answer->body) : json();
}

std::size_t kept(const fs::path& folder) {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

// The bytes of a frame, or "" and a failure.
std::string pictureOf(httplib::Client& client, const std::string& id) {
    for (int i = 0; i < 200; ++i) {
        const auto answer = postJson(client, "/v1/frames", frameOf(id));
        if (answer && answer->status == 200) return answer->body;
        if (!answer || (answer->status != 409 && answer->status != 503)) {
            ADD_FAILURE() << id << ": " << (answer ? answer->body : "no answer");
            return "";
        }
        std::this_thread::sleep_for(50ms);
    }
    ADD_FAILURE() << id << " never became ready";
    return "";
}

TEST(Uploads, AreOffUnlessTheServerSaysSo) {
    auto client = sharedServer().client();
    const json problem = problemOf(send(client, triangleGlb()), 403);
    EXPECT_THAT(problem["detail"].get<std::string>(), HasSubstr("--uploads"));
    EXPECT_EQ(problemOf(client.Delete("/v1/scenes/six-walls"), 403)["status"], 403);
    EXPECT_EQ(json::parse(client.Get("/v1/renderer")->body)["limits"]["uploadBytes"], 0);
    const auto long_ = send(client, std::string(70'000, 'x'));
    EXPECT_EQ(long_->status, 413) << "nobody sends much for nothing";
    EXPECT_EQ(client.Options("/v1/scenes")->get_header_value("Allow"), "GET, HEAD, POST");
}

TEST(Uploads, ASceneIsMadeOnceAndDrawn) {
    TestServer server(uploadConfig());
    auto client = server.client();
    const auto made = send(client, triangleGlb(), "model/gltf-binary", "?title=My%20triangle");
    ASSERT_TRUE(made);
    ASSERT_EQ(made->status, 201) << made->body;
    const std::string id = idOf(made);
    const json scene = json::parse(made->body);
    EXPECT_EQ(scene["id"], id);
    EXPECT_EQ(scene["title"], "My triangle");
    EXPECT_EQ(scene["state"], "ready");
    EXPECT_EQ(scene["uploaded"], true);
    EXPECT_EQ(scene["triangles"], 1);
    const std::string picture = pictureOf(client, id);

    const auto again = send(client, triangleGlb());
    EXPECT_EQ(again->status, 200) << again->body;
    EXPECT_EQ(idOf(again), id);
    EXPECT_EQ(json::parse(again->body)["title"], "My triangle");
    EXPECT_EQ(idOf(send(client, triangleGlb(1))).compare(id) == 0, false);
    EXPECT_EQ(json::parse(client.Get("/v1/renderer")->body)["limits"]["uploadBytes"], 64 << 20);

    // The same triangle in every other dress.
    const std::vector<PackedFile> files = {{"m/scene.gltf", triangleGltf("points.bin")},
                                           {"m/points.bin", triangleBuffer()}};
    for (const auto& [content, type] :
         {std::pair{triangleGltf(), "model/gltf+json"},
          std::pair{packed(Packing::zip, files), "application/zip"},
          std::pair{packed(Packing::tar, files), "application/x-tar"},
          std::pair{packed(Packing::tgz, files), "application/gzip"}}) {
        const auto other = send(client, content, type);
        ASSERT_EQ(other->status, 201) << type << ": " << other->body;
        EXPECT_EQ(pictureOf(client, idOf(other)), picture) << type;
    }
}

TEST(Uploads, DeletedOnesAreGoneFromListDiskAndMemory) {
    const Config config = uploadConfig();
    TestServer server(config);
    auto client = server.client();
    const std::string id = idOf(send(client, triangleGlb()));
    EXPECT_THAT(client.Get("/v1/scenes")->body, HasSubstr(id));
    EXPECT_EQ(client.Delete("/v1/scenes/" + id)->status, 204);
    EXPECT_EQ(client.Delete("/v1/scenes/" + id)->status, 404);
    problemOf(client.Get("/v1/scenes/" + id), 404);
    problemOf(postJson(client, "/v1/frames", frameOf(id)), 404);
    EXPECT_THAT(client.Get("/v1/scenes")->body, testing::Not(HasSubstr(id)));
    EXPECT_EQ(kept(config.scenes.uploads.folder), 0u);
    problemOf(client.Delete("/v1/scenes/six-walls"), 403);
    EXPECT_EQ(send(client, triangleGlb())->status, 201) << "and may come again";
}

TEST(Uploads, TheFrameThatIsBeingDrawnKeepsADeletedScene) {
    TestServer server(uploadConfig());
    auto client = server.client();
    const std::string id = idOf(send(client, triangleGlb()));
    auto held = server.holdRenderer();
    std::thread frame([&] {
        auto other = server.client();
        const auto answer = postJson(other, "/v1/frames", frameOf(id));
        ASSERT_TRUE(answer);
        EXPECT_EQ(answer->status, 200) << answer->body;
    });
    for (int i = 0; i < 2000 && server.service().queue().depth() == 0; ++i) {
        std::this_thread::sleep_for(2ms);
    }
    EXPECT_EQ(client.Delete("/v1/scenes/" + id)->status, 204);
    problemOf(postJson(client, "/v1/frames", frameOf(id)), 404);
    held.reset();
    frame.join();
}

TEST(Uploads, TheContentDecidesWhatAFileIs) {
    TestServer server(uploadConfig());
    auto client = server.client();
    const std::string glb = triangleGlb(), gltf = triangleGltf();
    problemOf(send(client, "v 0 0 0\n"), 415);
    problemOf(send(client, ""), 415);
    problemOf(send(client, glb, "application/zip"), 415);
    problemOf(send(client, gltf, "model/gltf-binary"), 415);
    problemOf(send(client, glb, "text/plain"), 415);
    // A page elsewhere could send these unasked.
    problemOf(send(client, glb, "multipart/form-data; boundary=x"), 415);
    problemOf(send(client, gltf, "application/x-www-form-urlencoded"), 415);
    problemOf(send(client, glb, kAny, "?name=x"), 422);
    EXPECT_EQ(statusOf(ask(server.server().port(),
                           "POST /v1/scenes HTTP/1.1\r\nHost: localhost\r\nContent-Length: " +
                               std::to_string((64 << 20) + 1) + "\r\n\r\n")),
              413);
}

TEST(Uploads, WhatGivesNoSceneIsRefusedWithItsReason) {
    Config config = uploadConfig();
    config.scenes.uploads.limits.count = 4;
    TestServer server(config);
    auto client = server.client();
    const auto reasonOf = [&](const std::string& content) {
        const json problem = problemOf(send(client, content), 422);
        EXPECT_THAT(problem["detail"].get<std::string>(),
                    testing::Not(HasSubstr(config.scenes.uploads.folder.string())));
        return problem.value("reason", "");
    };
    EXPECT_EQ(reasonOf(triangleGlb().substr(0, 100)), "malformed");
    EXPECT_EQ(reasonOf("glTF\2\0\0\0\x0c\0\0\0"), "malformed");
    EXPECT_EQ(reasonOf("{\"asset\": "), "malformed");
    EXPECT_EQ(reasonOf(packed(Packing::zip, {{"readme.txt", "words"}})), "unsupported");
    // The material library of 13 bytes that ends the reader (reliability.md 2.2).
    const std::string poison =
        packed(Packing::zip, {{"a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
                              {"a.mtl", "map_Kd a.png\n"}});
    EXPECT_EQ(reasonOf(poison), "crashed");
    EXPECT_EQ(reasonOf(poison), "crashed") << "and the next time";
    EXPECT_EQ(reasonOf(packed(Packing::zip, {{"a.gltf", triangleGltf("../../about.json")}})),
              "malformed");
    EXPECT_EQ(postJson(client, "/v1/frames", smallFrame())->status, 200);
    // They take nobody's room.
    for (unsigned i = 0; i < 4; ++i) EXPECT_EQ(send(client, triangleGlb(i))->status, 201) << i;
    EXPECT_EQ(json::parse(client.Get("/v1/scenes")->body)["scenes"].back()["state"], "ready");
}

TEST(Uploads, TimeAndCountsOfOneImportAreLimited) {
    Config config = uploadConfig();
    config.scenes.uploads.import.cpu = 1s;
    config.scenes.uploads.import.maxTriangles = 100;
    TestServer server(config);
    auto client = server.client();
    EXPECT_EQ(problemOf(send(client, triangleGlb(0, 200)), 422)["reason"], "limit");
    // Very many objects, which the reader's library handles in the square of their number
    // (reliability.md 2.2).
    std::string objects;
    for (int i = 0; i < 60'000; ++i) {
        objects += "o a" + std::to_string(i) + "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -3\n";
    }
    const std::string bomb = packed(Packing::zip, {{"a.obj", objects}});
    EXPECT_EQ(problemOf(send(client, bomb), 422)["reason"], "timedOut");
}

TEST(Uploads, FullMeansInsufficientStorage) {
    Config config = uploadConfig();
    config.scenes.uploads.limits.count = 2;
    TestServer server(config);
    auto client = server.client();
    const std::string first = idOf(send(client, triangleGlb(1)));
    EXPECT_EQ(send(client, triangleGlb(2))->status, 201);
    const json problem = problemOf(send(client, triangleGlb(3)), 507);
    EXPECT_THAT(problem["detail"].get<std::string>(), HasSubstr("DELETE"));
    EXPECT_EQ(send(client, triangleGlb(1))->status, 200) << "what is there needs no room";
    EXPECT_EQ(client.Delete("/v1/scenes/" + first)->status, 204);
    EXPECT_EQ(send(client, triangleGlb(3))->status, 201);
}

TEST(Uploads, WhoMayNotSendIsToldBeforeTheBodyComes) {
    Config config = uploadConfig();
    const fs::path token = config.scenes.uploads.folder.string() + ".token";
    std::ofstream(token) << "a-token-of-some-length\n";
    fs::permissions(token, fs::perms::owner_read | fs::perms::owner_write);
    config.http.access.tokenFile = token.string();
    TestServer server(config);
    const auto answerTo = [&](const std::string& more) {
        return ask(server.server().port(),
                   "POST /v1/scenes HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000\r\n" +
                       more + "\r\n",
                   1.0);
    };
    EXPECT_EQ(statusOf(answerTo("")), 401);
    EXPECT_EQ(statusOf(answerTo("Authorization: Bearer another\r\n")), 401);
    const std::string welcome =
        answerTo("Authorization: Bearer a-token-of-some-length\r\nExpect: 100-continue\r\n");
    EXPECT_EQ(statusOf(welcome), 100);
}

TEST(Uploads, AClientNeedNotWait) {
    TestServer server(uploadConfig());
    auto client = server.client();
    const httplib::Headers headers = {{"Prefer", "respond-async"}};
    const auto accepted = client.Post("/v1/scenes", headers, triangleGlb(), kAny);
    ASSERT_TRUE(accepted);
    ASSERT_THAT(accepted->status, testing::AnyOf(201, 202)) << accepted->body;
    EXPECT_EQ(accepted->get_header_value("Retry-After"), accepted->status == 202 ? "1" : "");
    EXPECT_FALSE(pictureOf(client, idOf(accepted)).empty());
}

TEST(Uploads, SceneMemoryIsToldAndAddsUp) {
    TestServer server(uploadConfig());
    auto client = server.client();
    const std::string id = idOf(send(client, triangleGlb(0, 1000)));
    pictureOf(client, id);
    const json memory = sceneAt(client, id)["memory"];
    // Vertices are not shared here: each has 3 indices of 4 bytes, on both sides.
    EXPECT_EQ(memory["meshes"], 2 * 3000 * (sizeof(Vertex) + 4));
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

// 12 swaps; CLERESTORY_SCENE_SWAPS says how many in a long run.
TEST(Uploads, ScenesTakeTurnsInAMemoryThatHoldsTwo) {
    const char* asked = std::getenv("CLERESTORY_SCENE_SWAPS");
    const int swaps = asked ? std::atoi(asked) : 12;
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
    std::atomic<bool> done{false};
    std::atomic<int> lost{0}, drawn{0};
    std::vector<std::thread> others;
    for (int k = 0; k < 3; ++k) {  // load on the scene that stays, and on those that swap
        others.emplace_back([&, k] {
            auto other = server.client();
            for (std::size_t i = 0; !done; ++i) {
                const std::string body =
                    k == 0 ? smallFrame() : frameOf(ids[(i / 3 + 2) % kScenes]);
                const auto answer = postJson(other, "/v1/frames", body);
                if (answer && answer->status == 200) {
                    ++drawn;
                } else if (!answer || answer->status != 409) {  // 409: asks again by itself
                    ++lost;
                }
            }
        });
    }
    double warm = 0.0;
    for (int i = 0; i < swaps; ++i) {
        if (i == 5) warm = residentBytes();
        const std::size_t which = static_cast<std::size_t>(i) % kScenes;
        EXPECT_EQ(pictureOf(client, ids[which]), pictures[which]) << i;
    }
    done = true;
    for (std::thread& other : others) other.join();
    EXPECT_EQ(lost, 0);
    EXPECT_GT(drawn, 0);
    EXPECT_LT(residentBytes() - warm, 2.0 * kEach) << "one that stayed at each swap is far more";
    std::printf("%d swaps under %d frames: %.1f MB after five, %.1f MB after all\n", swaps,
                drawn.load(), warm / 1e6, residentBytes() / 1e6);
    const SceneTotals totals = server.service().library().totals();
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

TEST(Uploads, AFullDiskCostsTheUploadAndNoFrame) {
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
    // What is small enough goes on: also a scene whose blob is too large for the cache.
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
    httplib::Client client() const {
        httplib::Client client("127.0.0.1", server.port());
        client.set_keep_alive(true);
        client.set_tcp_nodelay(true);
        client.set_read_timeout(120);
        return client;
    }
    void killWorker() {
        for (int i = 0; i < 3000 && server.supervisor()->processes().second == 0; ++i) {
            std::this_thread::sleep_for(10ms);
        }
        const pid_t worker = server.supervisor()->processes().first;
        kill(worker, SIGKILL);
        for (int i = 0; i < 3000 && server.supervisor()->processes().first == worker; ++i) {
            std::this_thread::sleep_for(1ms);
        }
    }
    Server server{workerConfig()};
};

TEST_F(UploadsOfWorkers, WhatEndsEveryRendererThatLoadsItIsGivenUp) {
    auto client = this->client();
    const std::string id = idOf(send(client, triangleGlb()));
    // As it looks after three renderers that began to load it and never came back.
    std::ofstream(folderOfThisTest() / id / "tries") << "...";
    killWorker();
    json problem;
    for (int i = 0; i < 200 && problem.is_null(); ++i) {
        const auto answer = postJson(client, "/v1/frames", frameOf(id));
        ASSERT_TRUE(answer);
        if (answer->status != 409) problem = problemOf(answer, 422);
    }
    EXPECT_EQ(problem["reason"], "crashed");
    EXPECT_EQ(problemOf(send(client, triangleGlb()), 422)["reason"], "crashed") << "for good";
    EXPECT_EQ(postJson(client, "/v1/frames", smallFrame())->status, 200);
}

TEST_F(UploadsOfWorkers, OutliveTheirRenderer) {
    auto client = this->client();
    const auto made = send(client, triangleGlb());
    ASSERT_EQ(made->status, 201) << made->body;
    const std::string id = idOf(made), picture = pictureOf(client, id);
    killWorker();
    EXPECT_EQ(pictureOf(client, id), picture);
    EXPECT_EQ(send(client, triangleGlb())->status, 200);
    EXPECT_EQ(client.Delete("/v1/scenes/" + id)->status, 204);
    killWorker();
    problemOf(postJson(client, "/v1/frames", frameOf(id)), 404);
    EXPECT_THAT(client.Get("/v1/scenes")->body, testing::Not(HasSubstr(id)));
}

}  // namespace
}  // namespace clerestory::test
