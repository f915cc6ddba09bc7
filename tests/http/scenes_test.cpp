// What can be rendered: the list, one scene, and scenes that load or fail to.
#include "tests/support/test_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <thread>

namespace clerestory::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

std::filesystem::path testFolder(const char* name) {
    const auto folder = std::filesystem::path(CLERESTORY_TEST_OUTPUT) / name;
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    return folder;
}

void write(const std::filesystem::path& file, const std::string& content) {
    std::ofstream(file, std::ios::binary) << content;
}

json jsonAt(httplib::Client& client, const std::string& path) {
    const auto result = client.Get(path);
    if (!result || result->status != 200) {
        ADD_FAILURE() << path << ": " << (result ? result->body : "no answer");
        return nullptr;
    }
    return json::parse(result->body);
}

// Asks until the scene is neither waiting nor loading.
json settled(httplib::Client& client, const std::string& id) {
    json scene;
    for (int i = 0; i < 600; ++i) {
        scene = jsonAt(client, "/v1/scenes/" + id);
        if (scene.is_null() || scene["state"] == "ready" || scene["state"] == "failed") break;
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return scene;
}

TEST(Scenes, TheListHoldsTheBuiltInOnesAndTheDefault) {
    auto client = sharedServer().client();
    for (const char* id : {"chapel", "six-walls", "orbiting-cubes", "teapots"}) settled(client, id);
    const json list = jsonAt(client, "/v1/scenes")["scenes"];
    std::vector<std::string> ids;
    for (const json& scene : list) {
        ids.push_back(scene["id"]);
        EXPECT_EQ(scene["state"], "ready");
        EXPECT_EQ(scene["default"], scene["id"] == "six-walls");
        EXPECT_GT(scene["triangles"].get<int>(), 0);
        EXPECT_EQ(scene["bounds"]["min"].size(), 3u);
    }
    EXPECT_THAT(ids, testing::IsSupersetOf({"chapel", "six-walls", "orbiting-cubes", "teapots"}));
}

TEST(Scenes, OneSceneTellsWhatGlowsAndWhy) {
    auto client = sharedServer().client();
    const json chapel = settled(client, "chapel");
    EXPECT_GE(chapel["triangles"].get<int>(), 60'000);
    EXPECT_EQ(chapel["defaultView"]["position"].size(), 3u);
    ASSERT_FALSE(chapel["emitters"].empty());
    for (const json& emitter : chapel["emitters"]) {
        EXPECT_GT(emitter["surfaces"].get<int>(), 0);
        EXPECT_THAT(emitter["reason"].get<std::string>(), HasSubstr("emissive"));
    }
    EXPECT_THAT(chapel["effects"], testing::Contains("emission"));
    for (const json& glass : chapel["glass"]) {
        EXPECT_THAT(glass["drawnAs"].get<std::string>(), HasSubstr("plain surface"));
    }
}

TEST(Scenes, ASceneThatLoadsIsAConflictForNow) {
    const auto folder = testFolder("loading");
    write(folder / "slow.glb", "any content");
    write(folder / "sleeper", "#!/bin/sh\nexec sleep 60\n");
    std::filesystem::permissions(folder / "sleeper", std::filesystem::perms::owner_all);
    Config config = testConfig();
    config.scenes.scenes = {"six-walls", (folder / "slow.glb").string()};
    config.scenes.import.importer = folder / "sleeper";
    config.scenes.import.limits.wallClock = std::chrono::milliseconds(4000);
    TestServer server(config);
    auto client = server.client();
    const auto result = postJson(client, "/v1/frames", R"({"scene": "slow"})");
    const json problem = problemOf(result, 409);
    EXPECT_THAT(problem["detail"].get<std::string>(), HasSubstr("slow is loading"));
    EXPECT_EQ(result->get_header_value("Retry-After"), "1");
    const json listed = jsonAt(client, "/v1/scenes/slow");
    EXPECT_EQ(listed["state"], "loading");
    EXPECT_TRUE(listed["progress"].is_number());
    EXPECT_EQ(postJson(client, "/v1/frames", smallFrame())->status, 200) << "others go on";

    EXPECT_EQ(settled(client, "slow")["state"], "failed") << "the time limit ends it";
    const json failed = problemOf(postJson(client, "/v1/frames", R"({"scene": "slow"})"), 422);
    EXPECT_EQ(failed["errors"][0]["pointer"], "/scene");
}

TEST(Scenes, AMalformedFileIsAClearRefusalAndNothingMore) {
    const auto folder = testFolder("malformed");
    write(folder / "not a model.glb", "glTF but not really");
    write(folder / "empty.obj", "");
    Config config = testConfig();
    config.scenes.folder = folder;
    TestServer server(config);
    auto client = server.client();
    for (const char* id : {"not-a-model", "empty"}) {
        const json scene = settled(client, id);
        EXPECT_EQ(scene["state"], "failed");
        const std::string failure = scene["failure"];
        EXPECT_FALSE(failure.empty());
        EXPECT_THAT(failure, testing::Not(HasSubstr(folder.string()))) << "no path of this machine";
        const json problem = problemOf(
            postJson(client, "/v1/frames", "{\"scene\": \"" + std::string(id) + "\"}"), 422);
        EXPECT_EQ(problem["detail"], failure);
    }
    EXPECT_EQ(postJson(client, "/v1/frames", smallFrame())->status, 200);
}

TEST(Scenes, AFileOfAFolderLoadsWhenAskedFor) {
    const auto folder = testFolder("folder");
    write(folder / "one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    Config config = testConfig();
    config.scenes.folder = folder;
    TestServer server(config);
    auto client = server.client();
    EXPECT_EQ(jsonAt(client, "/v1/scenes")["scenes"].back()["state"], "waiting");
    const std::string body = R"({"scene": "one", "width": 32, "height": 32})";
    const auto first = postJson(client, "/v1/frames", body);
    ASSERT_TRUE(first);
    EXPECT_THAT(first->status, testing::AnyOf(200, 409)) << first->body;  // 409 on a slow machine
    EXPECT_EQ(settled(client, "one")["state"], "ready");
    const auto frame = postJson(client, "/v1/frames", body);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->status, 200) << frame->body;
    EXPECT_EQ(jsonAt(client, "/v1/scenes/one")["triangles"], 1);
}

TEST(Scenes, ASourceThatIsNotThereIsOneClearLine) {
    Config config = testConfig();
    config.scenes.scenes = {"no-such-scene"};
    try {
        TestServer server(config);
        FAIL();
    } catch (const std::runtime_error& error) {
        EXPECT_THAT(error.what(), HasSubstr("no-such-scene"));
    }
}

}  // namespace
}  // namespace clerestory::test
