// No file outside the scene's folder is opened. A canary file is next to that folder; no scene may
// contain its contents.
#include "scene/import/base/scene_folder.h"
#include "tests/unit/import_support.h"

#include <sys/stat.h>

#include <algorithm>

namespace clerestory {
namespace {

class SceneFolderTest : public testing::Test {
protected:
    SceneFolderTest() {
        // The canary would work as a material library and as a vertex buffer alike.
        temporary_.write("canary.mtl", "newmtl canary\nKd 0.125 0.25 0.5\nmap_Kd canary.png\n");
        temporary_.write("canary.bin", std::string(36, '?'));
        std::filesystem::copy_file(ownScene("four colours.png"), temporary_ / "canary.png");
        std::filesystem::create_directory(temporary_ / "scene");
    }
    std::string canary(const std::string& name) const { return (temporary_ / name).string(); }
    // Ways to say "canary.EXTENSION" from within the scene's folder.
    std::vector<std::string> ways(const std::string& name) const {
        std::filesystem::create_symlink(temporary_ / name, temporary_ / ("scene/link-" + name));
        std::error_code ignored;
        std::filesystem::create_directory_symlink(temporary_ / "", temporary_ / "scene/up",
                                                  ignored);
        return {"../" + name,
                "..\\" + name,
                "./../" + name,
                "sub/../../" + name,
                canary(name),
                "link-" + name,
                "up/" + name,
                "%2e%2e%2f" + name,
                "file://" + canary(name),
                "/proc/self/cwd/../" + name};
    }

    TemporaryFolder temporary_;
};

TEST_F(SceneFolderTest, PathsOutsideTheFolderAreRejected) {
    const SceneFolder folder(temporary_ / "scene", 1000);
    temporary_.write("scene/sub/inside.txt", "inside");
    EXPECT_EQ(folder.read("sub/inside.txt"), "inside");
    EXPECT_EQ(folder.read("sub\\inside.txt"), "inside");
    EXPECT_EQ(folder.read("./sub/../sub/inside.txt"), "inside");
    for (const std::string& way : ways("canary.bin")) {
        EXPECT_FALSE(folder.has(way)) << way;
        EXPECT_FALSE(folder.has(percentDecoded(way))) << way;
        EXPECT_THROW(folder.read(way), ImportError) << way;
    }
    for (const char* name : {"", ".", "..", "sub", "/", "sub/inside.txt/", "/dev/zero"}) {
        EXPECT_FALSE(folder.has(name)) << name;
    }
    EXPECT_FALSE(folder.has(std::string("sub/inside.txt\0.png", 19)));
}

TEST_F(SceneFolderTest, PipesDoNotBlockAndLimitsApply) {
    ASSERT_EQ(mkfifo((temporary_ / "scene/pipe").c_str(), 0600), 0);
    temporary_.write("scene/large", std::string(1001, 'x'));
    temporary_.write("scene/small", std::string(1000, 'x'));
    const SceneFolder folder(temporary_ / "scene", 1000);
    EXPECT_FALSE(folder.has("pipe"));
    EXPECT_THROW(folder.read("large"), ImportError);
    for (int i = 0; i < 4; ++i) {
        EXPECT_EQ(folder.read("small").size(), 1000u);
    }
    EXPECT_THROW(folder.read("small"), ImportError) << "all files together have a limit, too";
}

TEST_F(SceneFolderTest, MaterialLibrariesAndImages) {
    const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl canary\nf 1 2 3\n";
    for (const std::string& way : ways("canary.mtl")) {
        const auto file = temporary_.write("scene/a.obj", "mtllib " + way + "\n" + triangle);
        const Scene scene = importScene(file);
        for (const Material& m : scene.materials) {
            EXPECT_NE(m.baseColor.x, 0.125f) << way;
        }
    }
    for (const std::string& way : ways("canary.png")) {
        temporary_.write("scene/b.mtl", "newmtl canary\nKd 1 1 1\nmap_Kd " + way + "\n");
        const Scene scene =
            importScene(temporary_.write("scene/b.obj", "mtllib b.mtl\n" + triangle));
        EXPECT_TRUE(scene.images.empty()) << way;
        EXPECT_TRUE(warning(scene, "missingTexture")) << way;
    }
}

TEST_F(SceneFolderTest, GltfBuffersAndImages) {
    const std::string scene = R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri": ")";
    for (std::string way : ways("canary.bin")) {
        std::replace(way.begin(), way.end(), '\\', '/');
        const auto file = temporary_.write("scene/a.gltf", scene + way + "\"}]}");
        const ImportError error = refusal(file);
        EXPECT_EQ(error.reason(), ImportError::Reason::malformed) << way;
        EXPECT_NE(std::string(error.what()).find("is missing"), std::string::npos) << way;
    }
}

TEST_F(SceneFolderTest, SymbolicLinksAreNotFollowed) {
    std::filesystem::copy_file(ownScene("materials.obj"), temporary_ / "outside.obj");
    std::filesystem::create_symlink(temporary_ / "outside.obj", temporary_ / "scene/link.obj");
    EXPECT_EQ(refusal(temporary_ / "scene/link.obj").reason(), ImportError::Reason::notFound);
}

TEST(PercentDecoding, DecodesEscapes) {
    EXPECT_EQ(percentDecoded("a%20b%2Fc.png"), "a b/c.png");
    EXPECT_EQ(percentDecoded("%E2%9D%A4"), "\xE2\x9D\xA4");
    EXPECT_EQ(percentDecoded("100%"), "100%");
    EXPECT_EQ(percentDecoded("%zz%4"), "%zz%4");
    EXPECT_EQ(percentDecoded(""), "");
}

}  // namespace
}  // namespace clerestory
