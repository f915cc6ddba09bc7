// Cached scenes: found without an importer, and never if any of their sources, or the cache file,
// has changed.
#include "scene/import/cache/scene_cache.h"
#include "tests/support/scene_files.h"
#include "tests/unit/import_support.h"

#include <algorithm>
#include <thread>

namespace clerestory::test {
namespace {

namespace fs = std::filesystem;

class ImportCache : public testing::Test {
protected:
    ImportCache() { start(); }

    // The state that a new process finds.
    void start(std::uint64_t mostBytes = 1 << 30, const std::string& version = "1") {
        options.cache = std::make_shared<SceneCache>(SceneCacheOptions{
            .folder = cache(),
            .maxBytes = mostBytes,
            .version = version,
            .reportFailure = [this](const std::string& words) { complaints.push_back(words); }});
    }
    fs::path cache() const { return folder / "cache"; }
    std::vector<fs::path> files() const {
        std::vector<fs::path> list;
        for (const auto& entry : fs::directory_iterator(cache())) list.push_back(entry.path());
        std::sort(list.begin(), list.end());
        return list;
    }
    // Whether the scene is had without an importer.
    bool isKept(const fs::path& scene) const {
        options.cache->flush();
        ImportOptions none = options;
        none.importer = folder / "no-such-program";
        try {
            importScene(scene, none);
            return true;
        } catch (const std::runtime_error&) {
            return false;
        }
    }

    TemporaryFolder folder;
    ImportOptions options;
    std::vector<std::string> complaints;
};

TEST_F(ImportCache, ReturnsTheImportedScene) {
    for (const char* name :
         {"Box/Box.glb", "FormatsOBJ/spider.obj", "BoxTextured/BoxTextured.glb"}) {
        const fs::path file = sharedScene(name);
        if (!fs::exists(file)) continue;
        const Scene made = importScene(file, options);
        ASSERT_TRUE(isKept(file)) << name;
        const Scene kept = importScene(file, options);
        EXPECT_EQ(kept.contentHash, made.contentHash);
        EXPECT_EQ(kept.title, made.title);
        EXPECT_EQ(kept.images.size(), made.images.size());
        EXPECT_TRUE(sceneProblems(kept).empty());
    }
    const fs::path own = folder.write("own.gltf", triangleGltf());
    const Scene made = importScene(own, options);
    EXPECT_TRUE(isKept(own));
    EXPECT_EQ(importScene(own, options).contentHash, made.contentHash);
    EXPECT_TRUE(complaints.empty());
}

TEST_F(ImportCache, EqualContentElsewhereIsFound) {
    const fs::path here = folder.write("here/a.gltf", triangleGltf("points.bin"));
    folder.write("here/points.bin", triangleBuffer());
    const fs::path there = folder.write("there/a.gltf", triangleGltf("points.bin"));
    folder.write("there/points.bin", triangleBuffer());
    importScene(here, options);
    EXPECT_TRUE(isKept(there));
}

TEST_F(ImportCache, ChangesOfInputFilesAreDetected) {
    const fs::path scene = folder.write("a/a.gltf", triangleGltf("points.bin"));
    const fs::path points = folder.write("a/points.bin", triangleBuffer());
    importScene(scene, options);
    ASSERT_TRUE(isKept(scene));
    std::string moved = triangleBuffer();
    moved[3] = 0x40;  // a corner goes to x = 2
    const auto keptAfter = [&](const char* name, const std::string& content) {
        folder.write(name, content);
        return isKept(scene);
    };
    EXPECT_FALSE(keptAfter("a/points.bin", moved)) << "another buffer";
    EXPECT_TRUE(keptAfter("a/points.bin", triangleBuffer())) << "the same again";
    EXPECT_TRUE(keptAfter("a/readme.txt", "words")) << "that file was not read";
    EXPECT_FALSE(keptAfter("a/a.clerestory.json", "{}")) << "a side file that was not there";
    fs::remove(folder / "a/a.clerestory.json");
    EXPECT_TRUE(isKept(scene));
    fs::remove(points);
    EXPECT_FALSE(isKept(scene)) << "no buffer";
    folder.write("a/points.bin", triangleBuffer());
    EXPECT_FALSE(keptAfter("a/a.gltf", triangleGltf("points.bin") + "\n")) << "another scene file";
    folder.write("a/a.gltf", triangleGltf("points.bin"));
    ImportOptions tighter = options;
    tighter.limits.maxTriangles = 1000;
    tighter.importer = folder / "no-such-program";
    EXPECT_THROW(importScene(scene, tighter), std::runtime_error) << "other limits";
    start(1 << 30, "2");
    EXPECT_FALSE(isKept(scene)) << "another program";
}

TEST_F(ImportCache, TruncationAndChangedBytesAreDetected) {
    const fs::path scene = folder.write("a.gltf", triangleGltf());
    importScene(scene, options);
    options.cache->flush();
    ASSERT_EQ(files().size(), 1u);
    const fs::path file = files().front();
    std::ifstream stream(file, std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(stream), {}};
    const auto key = options.cache->keyOf(scene, options.limits);
    ASSERT_TRUE(key);
    const auto foundIn = [&](const std::string& bytes) {
        std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
        return options.cache->find(*key).has_value();
    };
    for (std::size_t size = 0; size < whole.size(); ++size) {
        ASSERT_FALSE(foundIn(whole.substr(0, size))) << "cut at " << size;
    }
    for (std::size_t at = 0; at < whole.size(); at += 7) {
        std::string changed = whole;
        changed[at] = static_cast<char>(changed[at] ^ (1 << at % 8));
        ASSERT_FALSE(foundIn(changed)) << "changed at " << at;
    }
    EXPECT_FALSE(foundIn(whole + "!"));
    EXPECT_TRUE(foundIn(whole));
    foundIn(whole.substr(0, 100));
    importScene(scene, options);
    EXPECT_TRUE(isKept(scene)) << "and it is repaired";
}

TEST_F(ImportCache, TheOldestAreEvicted) {
    std::vector<fs::path> scenes;
    for (unsigned i = 0; i < 4; ++i) {
        scenes.push_back(folder.write("s" + std::to_string(i) + ".glb", triangleGlb(i, 1000)));
        importScene(scenes.back(), options);
        options.cache->flush();
        if (i == 0) start(3 * fs::file_size(files().front()) + 1000);
        std::this_thread::sleep_for(std::chrono::milliseconds(20));  // file times differ
        EXPECT_TRUE(isKept(scenes[0])) << "used, and so the latest";
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    EXPECT_EQ(files().size(), 3u);
    EXPECT_FALSE(isKept(scenes[1]));
    EXPECT_TRUE(isKept(scenes[0]) && isKept(scenes[2]) && isKept(scenes[3]));
}

TEST_F(ImportCache, UnwritableFoldersStillImport) {
    folder.write("cache", "a file where the folder should be");
    const fs::path scene = folder.write("a.gltf", triangleGltf());
    for (int i = 0; i < 3; ++i) EXPECT_EQ(triangleCount(importScene(scene, options)), 1u);
    options.cache->flush();
    EXPECT_EQ(complaints.size(), 1u) << "one line is enough";
    fs::remove(cache());
    importScene(scene, options);
    EXPECT_TRUE(isKept(scene));
    fs::remove_all(cache());  // while the server runs
    importScene(scene, options);
    EXPECT_TRUE(isKept(scene));
    EXPECT_EQ(complaints.size(), 1u);
}

TEST_F(ImportCache, FailuresAreNotCached) {
    const fs::path scene = folder.write("a.gltf", "{");
    EXPECT_THROW(importScene(scene, options), ImportError);
    EXPECT_FALSE(fs::exists(cache()));
}

}  // namespace
}  // namespace clerestory::test
