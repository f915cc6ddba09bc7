// Scenes over HTTP: the list, one scene, and scenes that load or fail to load.
#include "tests/support/soon.h"
#include "tests/support/test_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

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
    within(kPatience, [&] {
        scene = jsonAt(client, "/v1/scenes/" + id);
        return scene.is_null() || scene["state"] == "ready" || scene["state"] == "failed";
    });
    return scene;
}

TEST(Scenes, TheListContainsBuiltInScenesAndTheDefault) {
    auto client = sharedServer().client();
    for (const char* id : {"chapel", "six-walls", "orbiting-cubes", "teapots", "meadow"}) {
        settled(client, id);
    }
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

TEST(Scenes, ASceneListsItsEmittersGlassAndMirrorsWithReasons) {
    auto client = sharedServer().client();
    const json chapel = settled(client, "chapel");
    EXPECT_GE(chapel["triangles"].get<int>(), 60'000);
    EXPECT_EQ(chapel["defaultView"]["position"].size(), 3u);
    EXPECT_EQ(chapel["effects"],
              json({"emission", "refraction", "planarReflection", "environmentReflection"}));
    for (const char* kind : {"emitters", "glass", "flatMirrors", "curvedMirrors"}) {
        ASSERT_FALSE(chapel[kind].empty()) << kind;
        EXPECT_EQ(chapel["counts"][kind], chapel[kind].size());
        for (const json& entry : chapel[kind]) {
            EXPECT_GT(entry["area"].get<double>(), 0.0);
            EXPECT_GT(entry["objectId"].get<int>(), 0);
            for (const char* word : {"node", "mesh", "material", "reason"}) {
                EXPECT_FALSE(entry[word].get<std::string>().empty()) << word;
            }
        }
    }
    const auto entry = [&](const char* kind, const char* node) {
        for (const json& e : chapel[kind]) {
            if (e["node"] == node) return e;
        }
        ADD_FAILURE() << node << " is none of the " << kind;
        return json::object({{"reason", ""}});
    };
    EXPECT_EQ(entry("flatMirrors", "floor")["normal"], json({0.0, 1.0, 0.0}));
    EXPECT_THAT(entry("flatMirrors", "floor")["reason"].get<std::string>(),
                HasSubstr("in one plane"));
    EXPECT_THAT(entry("curvedMirrors", "brassFigure")["reason"].get<std::string>(),
                HasSubstr("metal"));
    EXPECT_EQ(entry("glass", "glassBall")["kind"], "solid");
    EXPECT_EQ(entry("glass", "window")["kind"], "pane");
    EXPECT_THAT(entry("emitters", "altarFlames")["reason"].get<std::string>(), HasSubstr("emits"));
    const json walls = settled(client, "six-walls");
    EXPECT_EQ(walls["effects"], json({"emission", "environmentReflection"}));
    EXPECT_EQ(walls["emitters"].size(), 6u);
    EXPECT_NEAR(walls["emitters"][0]["area"].get<double>(), 16.0, 1e-6);
}

TEST(Scenes, ASideFileDescribesItsModel) {
    const auto folder = testFolder("side");
    for (const char* name : {"plain", "mirror", "broken"}) {
        write(folder / (std::string(name) + ".obj"),
              "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nf 1 2 3 4\n");
    }
    write(folder / "mirror.clerestory.json",
          R"({"overrides": [{"node": "mirror.obj", "reflection": "mirror"}],
              "probes": [{"name": "middle", "position": [1, 1, 1], "size": 0.5}]})");
    write(folder / "broken.clerestory.json", R"({"overrides": [{"node": "brokn.obj"}], )");
    Config config = testConfig();
    config.scenes.folder = folder;
    config.scenes.scenes = {"plain.obj", "mirror.obj", "broken.obj"};
    for (std::string& source : config.scenes.scenes) source = (folder / source).string();
    TestServer server(config);
    auto client = server.client();
    EXPECT_EQ(settled(client, "plain")["effects"], json::array());
    const json mirror = settled(client, "mirror");
    ASSERT_EQ(mirror["flatMirrors"].size(), 1u) << mirror.dump();
    EXPECT_EQ(mirror["flatMirrors"][0]["area"], 4.0);
    EXPECT_THAT(mirror["flatMirrors"][0]["reason"].get<std::string>(),
                HasSubstr("reflection: mirror"));
    EXPECT_EQ(mirror["probes"][0]["name"], "middle");
    EXPECT_EQ(mirror["probes"][0]["position"], json({1.0, 1.0, 1.0}));
    const json broken = settled(client, "broken");
    EXPECT_EQ(broken["state"], "ready");
    ASSERT_EQ(broken["warnings"].size(), 1u) << broken["warnings"].dump();
    EXPECT_EQ(broken["warnings"][0]["code"], "sideFile");
    EXPECT_EQ(broken["warnings"][0]["subject"], "broken.clerestory.json");
}

TEST(Scenes, ALoadingSceneIsAConflict) {
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
    ASSERT_TRUE(
        within(kPatience, [&] { return jsonAt(client, "/v1/scenes/slow")["state"] != "waiting"; }));
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

TEST(Scenes, AMalformedFileIsRejectedAndHarmsNothing) {
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

TEST(Scenes, ASceneOfAFolderLoadsOnRequest) {
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

TEST(Scenes, ABuiltInSceneLoadsOnRequest) {
    TestServer server;
    auto client = server.client();
    EXPECT_EQ(settled(client, "six-walls")["state"], "ready");
    const json list = jsonAt(client, "/v1/scenes");
    for (const json& scene : list["scenes"]) {
        EXPECT_EQ(scene["state"], scene["id"] == "six-walls" ? "ready" : "waiting") << scene;
    }
    EXPECT_EQ(settled(client, "orbiting-cubes")["state"], "ready");
    EXPECT_GT(jsonAt(client, "/v1/scenes/orbiting-cubes")["triangles"].get<int>(), 0);
}

TEST(Scenes, AMissingSourcePrintsOneLine) {
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
