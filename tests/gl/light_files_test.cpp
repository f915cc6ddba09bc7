// Light between surfaces that is stored on disk: found again, and never wrong.
#include "support.h"
#include "tests/support/temporary_folder.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <string>
#include <vector>

using namespace clerestory;
using namespace clerestory::test;

namespace fs = std::filesystem;

namespace {

// A lamp over a floor, and a ball that moves between them.
Scene lampOverFloor(float emitted, bool ball) {
    Scene scene;
    scene.id = "lamp";
    scene.environment = "black";
    Material floor;
    floor.metallic = 0.0f;
    place(scene, quad(2.0f, addMaterial(scene, floor)));
    Material lamp = glowing(glm::vec3(emitted));
    lamp.doubleSided = true;
    place(scene, quad(0.5f, addMaterial(scene, lamp)), moved(0.0, 0.0, 1.0));
    if (ball) {
        place(scene, sphere(0.2f, 16, addMaterial(scene, floor)));
        moveLast(scene, {0.0f, 0.0f, 0.4f}, {0.5f, 0.0f, 0.4f});
    }
    updateContentHash(scene);
    return scene;
}

FrameRequest requestOfLamp() {
    FrameRequest r;
    r.scene = "lamp";
    r.width = r.height = 32;
    r.camera.position = {1.5, 0.0, 0.7};
    r.camera.target = {0.0, 0.0, 0.0};
    r.output.format = OutputFormat::npy;
    r.effects.indirectLight = true;
    return r;
}

// What one start of the program does: a frame with complete light.
struct Start {
    std::vector<std::byte> picture;
    std::uint64_t computed = 0;
    std::uint32_t revision = 0;
    std::uint32_t revisionAtFirst = 0;  // of a frame that does not wait
    std::vector<std::string> failures;
};

Start start(LightOptions options, float emitted = 4.0f, bool ball = false) {
    Start result;
    options.addedTriangles = options.places = 2000;
    options.background = false;
    options.reportFailure = [&](const std::string& words) { result.failures.push_back(words); };
    {
        Renderer renderer({.light = options});
        renderer.addScene(lampOverFloor(emitted, ball));
        const FrameRequest r = requestOfLamp();
        result.revisionAtFirst = renderer.render(r).light.revision;
        const LightState light = renderer.completeLight(r);
        EXPECT_TRUE(light.complete) << light.failure;
        Frame frame = renderer.render(r);
        EXPECT_GT(centerColor(frame.image).x, 0.01f);
        result.picture = std::move(frame.image.data);
        result.revision = frame.light.revision;
        result.computed = renderer.counters().lightsComputed;
    }
    return result;
}

std::vector<fs::path> filesIn(const fs::path& folder) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

std::string contentOf(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

void write(const fs::path& file, const std::string& content) {
    std::ofstream(file, std::ios::binary) << content;
}

}  // namespace

TEST(LightFiles, StoredLightIsNotComputedAgain) {
    const TemporaryFolder folder;
    const Start first = start({.folder = folder / "cache"}),
                second = start({.folder = folder / "cache"});
    EXPECT_EQ(first.computed, 1u);
    EXPECT_EQ(second.computed, 0u);
    EXPECT_EQ(second.revision, first.revision);
    EXPECT_EQ(first.revisionAtFirst, 0u);
    EXPECT_EQ(second.revisionAtFirst, first.revision) << "in the first frame";
    EXPECT_TRUE(second.picture == first.picture);
    EXPECT_EQ(filesIn(folder / "cache").size(), 1u);
    EXPECT_EQ(start({}).computed, 1u);  // without a folder
}

TEST(LightFiles, StoredLightHasWhatMoves) {
    const TemporaryFolder folder;
    const Start first = start({.folder = folder.path()}, 4.0f, true);
    const Start second = start({.folder = folder.path()}, 4.0f, true);
    EXPECT_EQ(second.computed, 0u);
    EXPECT_TRUE(second.picture == first.picture);
    EXPECT_FALSE(start({}, 4.0f, false).picture == first.picture);
}

// The first frame finds refined meshes that were made and uploaded before it. At rest they are
// freed unless a frame shows them.
TEST(LightFiles, StoredLightIsReadByTheWarmUp) {
    const TemporaryFolder folder;
    const Start first = start({.folder = folder.path()});
    const LightOptions options{
        .background = false, .addedTriangles = 2000, .places = 2000, .folder = folder.path()};
    Renderer renderer({.light = options});
    renderer.addScene(lampOverFloor(4.0f, false));
    const FrameRequest r = requestOfLamp();
    const auto warmUp = [&] {
        WarmUp steps = renderer.beginWarmUp({r});
        while (renderer.advance(steps)) {
        }
    };
    const auto uploadedByFrame = [&] {
        const std::uint64_t before = renderer.counters().bytesShared;
        const Frame frame = renderer.render(r);
        EXPECT_EQ(frame.light.revision, first.revision);
        EXPECT_TRUE(frame.image.data == first.picture);
        return renderer.counters().bytesShared - before;
    };
    warmUp();
    renderer.releaseScratch();
    const std::uint64_t uploaded = uploadedByFrame();
    if (renderer.identity().software) {  // a graphics card has no buffers that share memory
        EXPECT_GT(uploaded, 0u) << "a standby at rest holds the scene once";
    }
    renderer.releaseScratch();
    EXPECT_EQ(uploadedByFrame(), 0u) << "a frame shows it";
    renderer.addScene(lampOverFloor(4.0f, false));
    warmUp();
    EXPECT_EQ(uploadedByFrame(), 0u);
}

TEST(LightFiles, OtherLightAndOtherVersionsAreOtherFiles) {
    const TemporaryFolder folder;
    const Start bright = start({.folder = folder.path(), .version = "1"});
    const Start dim = start({.folder = folder.path(), .version = "1"}, 1.0f);
    EXPECT_EQ(dim.computed, 1u);
    EXPECT_FALSE(dim.picture == bright.picture);
    EXPECT_EQ(start({.folder = folder.path(), .version = "2"}).computed, 1u);
    EXPECT_EQ(filesIn(folder.path()).size(), 3u);
}

TEST(LightFiles, DamagedFilesAreReplaced) {
    const TemporaryFolder folder, other;
    const Start whole = start({.folder = folder.path()});
    start({.folder = other.path()}, 1.0f);
    const fs::path file = filesIn(folder.path()).at(0);
    const std::string good = contentOf(file);
    std::vector<std::string> damaged = {"",
                                        "CLLIGHT",
                                        good.substr(0, good.size() / 2),
                                        good + "more",
                                        std::string(good.size(), '\xff'),
                                        contentOf(filesIn(other.path()).at(0))};
    // One bit: of each field of the header, of the bodies, of the values.
    for (const std::size_t at : std::initializer_list<std::size_t>{
             0, 8, 12, 16, 24, 32, 40, 48, 57, 80, 96, 108, 112, 120, 128, 140, good.size() - 1}) {
        damaged.push_back(good);
        damaged.back()[at] = static_cast<char>(damaged.back()[at] ^ 1);
    }
    for (std::size_t i = 0; i < damaged.size(); ++i) {
        write(file, damaged[i]);
        const Start again = start({.folder = folder.path()});
        EXPECT_EQ(again.computed, 1u) << i;
        EXPECT_TRUE(again.picture == whole.picture) << i;
        EXPECT_TRUE(contentOf(file) == good) << i;
    }
}

TEST(LightFiles, AFolderThatCannotBeWrittenIsReported) {
    const TemporaryFolder folder;
    write(folder / "file", "");
    const Start result = start({.folder = folder / "file/below"});
    EXPECT_EQ(result.computed, 1u);
    ASSERT_EQ(result.failures.size(), 1u);
    EXPECT_NE(result.failures[0].find((folder / "file/below").string()), std::string::npos)
        << result.failures[0];
}

TEST(LightFiles, FilesUsedLongestAgoMakeRoom) {
    const TemporaryFolder folder;
    start({.folder = folder.path()});
    const fs::path first = filesIn(folder.path()).at(0);
    fs::last_write_time(first, fs::last_write_time(first) - std::chrono::hours(1));
    const std::uint64_t room = fs::file_size(first) * 3 / 2;
    start({.folder = folder.path(), .folderBytes = room}, 1.0f);
    ASSERT_EQ(filesIn(folder.path()).size(), 1u);
    EXPECT_NE(filesIn(folder.path())[0], first);
}
