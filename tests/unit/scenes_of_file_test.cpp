// The scenes of a glTF file: the default one, others by name and number, and the cache of each.
#include "import_support.h"
#include "tests/support/scene_files.h"

#include "scene/import/cache/scene_cache.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace clerestory::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

// Scenes "day", "night" and one without a name, of one, two and one nodes.
json threeScenes() {
    json file = json::parse(triangleGltf());
    file["nodes"] = {{{"name", "a"}, {"mesh", 0}},
                     {{"name", "b"}, {"mesh", 0}},
                     {{"name", "c"}, {"mesh", 0}, {"translation", {5, 0, 0}}},
                     {{"name", "d"}, {"mesh", 0}}};
    file["scenes"] = {{{"name", "day"}, {"nodes", {0}}},
                      {{"name", "night"}, {"nodes", {1, 2}}},
                      {{"nodes", {3}}}};
    file.erase("scene");
    return file;
}

std::vector<std::string> nodesOf(const Scene& scene) {
    std::vector<std::string> names;
    for (const Node& node : scene.nodes) names.push_back(node.name);
    return names;
}

using Names = std::vector<std::string>;

TEST(ScenesOfFile, AreChosenByNameOrNumber) {
    const TemporaryFolder folder;
    const auto file = folder.write("town.gltf", threeScenes().dump());
    const auto scene = [&](const std::string& which) {
        return importScene(file, ImportOptions{.scene = which});
    };
    const Scene first = scene("");
    EXPECT_EQ(nodesOf(first), (Names{"a"}));
    EXPECT_EQ(first.scenesOfFile, (Names{"day", "night", "scene 3"}));
    EXPECT_EQ(first.sceneOfFile, 0u);
    EXPECT_EQ(first.title, "town");
    for (const char* which : {"1", "night"}) {
        const Scene night = scene(which);
        EXPECT_EQ(nodesOf(night), (Names{"b", "c"}));
        EXPECT_EQ(night.sceneOfFile, 1u);
        EXPECT_EQ(night.title, "town: night");
        EXPECT_NE(night.contentHash, first.contentHash);
        EXPECT_GT(lastingBounds(night, restPose(night)).max.x, 5.0f);
    }
    EXPECT_EQ(nodesOf(scene("scene 3")), (Names{"d"}));
    EXPECT_EQ(sceneProblems(first), Names{});
    Scene wrong = first;
    wrong.sceneOfFile = 3;
    EXPECT_NE(sceneProblems(wrong), Names{});
}

TEST(ScenesOfFile, TheFileNamesTheDefault) {
    const TemporaryFolder folder;
    json file = threeScenes();
    file["scene"] = 1;
    const Scene night = importScene(folder.write("town.gltf", file.dump()));
    EXPECT_EQ(nodesOf(night), (Names{"b", "c"}));
    EXPECT_EQ(night.sceneOfFile, 1u);
    // A number is a number, unless it is a name.
    file["scenes"][2]["name"] = "0";
    const auto numbered = folder.write("numbered.gltf", file.dump());
    EXPECT_EQ(nodesOf(importScene(numbered, ImportOptions{.scene = "0"})), (Names{"d"}));
}

TEST(ScenesOfFile, OneSceneHasNoList) {
    const TemporaryFolder folder;
    const Scene scene = importScene(folder.write("one.gltf", triangleGltf()));
    EXPECT_TRUE(scene.scenesOfFile.empty());
}

TEST(ScenesOfFile, ErrorsNameWhatThereIs) {
    const TemporaryFolder folder;
    const auto file = folder.write("town.gltf", threeScenes().dump());
    for (const char* which : {"3", "dusk", "-1", "01", "18446744073709551616"}) {
        const ImportError error = refusal(file, ImportOptions{.scene = which});
        EXPECT_EQ(error.reason(), ImportError::Reason::notFound);
        EXPECT_THAT(error.what(),
                    HasSubstr(std::string("no scene '") + which + "', but day, night, scene 3"));
    }
    const auto obj = folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    EXPECT_THAT(refusal(obj, ImportOptions{.scene = "1"}).what(), HasSubstr("only glTF files"));
    json many = threeScenes();
    many["scenes"] = json::array();
    for (int i = 0; i < 1025; ++i) many["scenes"].push_back({{"nodes", {0}}});
    EXPECT_EQ(refusal(folder.write("many.gltf", many.dump())).reason(), ImportError::Reason::limit);
    json outside = threeScenes();
    outside["scene"] = 3;
    EXPECT_EQ(refusal(folder.write("outside.gltf", outside.dump())).reason(),
              ImportError::Reason::malformed);
}

TEST(ScenesOfFile, AreCachedSeparately) {
    const TemporaryFolder folder, cache;
    const auto file = folder.write("town.gltf", threeScenes().dump());
    ImportOptions options{.cache = std::make_shared<SceneCache>(
                              SceneCacheOptions{.folder = cache.path(), .version = "1"})};
    for (int round = 0; round < 2; ++round) {
        options.scene = "";
        EXPECT_EQ(nodesOf(importScene(file, options)), (Names{"a"}));
        options.scene = "night";
        EXPECT_EQ(nodesOf(importScene(file, options)), (Names{"b", "c"}));
        options.cache->flush();
    }
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(cache.path()), {}), 2);
}

TEST(ScenesOfFile, SourcesAreFilesWithAColon) {
    const TemporaryFolder folder;
    const std::string plain = folder.write("town.gltf", "{}").string();
    const std::string colon = folder.write("a:b.gltf", "{}").string();
    EXPECT_EQ(sceneSource(plain).file, plain);
    EXPECT_EQ(sceneSource(plain).scene, "");
    EXPECT_EQ(sceneSource(plain + ":night sky").file, plain);
    EXPECT_EQ(sceneSource(plain + ":night sky").scene, "night sky");
    EXPECT_EQ(sceneSource(colon).file, colon);
    EXPECT_EQ(sceneSource(colon + ":1").file, colon);
    EXPECT_EQ(sceneSource("chapel").file, "chapel");
    EXPECT_EQ(sceneSource("missing.gltf:1").file, "missing.gltf:1");
}

}  // namespace
}  // namespace clerestory::test
