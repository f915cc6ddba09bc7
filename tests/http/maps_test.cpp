// Stored maps on a real server: a KTX2 cube on a mirror, rotated by requests in every form and
// permanently by a side file; blurred; and files that the server must not start with.
#include "tests/support/ktx_files.h"
#include "tests/support/test_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace clerestory::test {
namespace {

using nlohmann::json;

// Six faces, each of one colour, OpenGL's order: +X -X +Y -Y +Z -Z.
constexpr std::array<glm::vec3, 6> kColors = {
    {{1, 0, 0}, {0, 1, 1}, {0, 1, 0}, {1, 0, 1}, {0, 0, 1}, {1, 1, 0}}};

std::filesystem::path folder() {
    const auto path = std::filesystem::path(CLERESTORY_TEST_OUTPUT) / "maps";
    std::filesystem::create_directories(path);
    return path;
}

std::filesystem::path writtenFile(const std::string& name, const std::string& content) {
    std::ofstream(folder() / name, std::ios::binary) << content;
    return folder() / name;
}

std::filesystem::path sixColors() {
    Cube cube{8, {}};
    for (const glm::vec3& color : kColors) cube.texels.insert(cube.texels.end(), 64, color);
    return writtenFile("six-colours.ktx2", ktx2File(cube, KtxFormat::half4));
}

// A square mirror of 2 x 2 m in the plane z = 0.
const char* const kMirror =
    "mtllib mirror.mtl\nusemtl mirror\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvn 0 0 1\n"
    "f 1//1 2//1 3//1\nf 1//1 3//1 4//1\n";

TestServer& server() {
    static TestServer instance([] {
        writtenFile("mirror.mtl", "newmtl mirror\nKd 1 1 1\nKs 1 1 1\nPm 1\nPr 0\n");
        writtenFile("mirror.clerestory.json",
                    R"({"overrides": [{"material": "mirror", "metallic": 1, "roughness": 0,
                        "baseColor": [1, 1, 1]}]})");
        writtenFile("turned.obj", kMirror);
        // A permanent quarter turn about +Y: the map's +Z appears at +X.
        writtenFile(
            "turned.clerestory.json",
            R"({"environment": {"map": "six-colours", "rotation": [0, 1.5707963267948966, 0]},
                        "overrides": [{"material": "mirror", "metallic": 1, "roughness": 0,
                                       "baseColor": [1, 1, 1]}]})");
        writtenFile("lost.obj", kMirror);
        writtenFile("lost.clerestory.json", R"({"environment": {"map": "nowhere"}})");
        Config config = testConfig();
        config.scenes.environments = {sixColors()};
        config.scenes.scenes = {writtenFile("mirror.obj", kMirror).string(),
                                (folder() / "turned.obj").string(),
                                (folder() / "lost.obj").string()};
        return config;
    }());
    return instance;
}

// The middle of a picture of linear colours, seen from `eye` towards the origin.
struct Seen {
    glm::vec3 color{-1.0f};
    std::string bytes;
};
Seen seen(const std::string& scene, const std::string& eye, const std::string& more) {
    auto client = server().client();
    const auto result =
        postUntilReady(client, "/v1/frames",
                       R"({"scene": ")" + scene +
                           R"(", "width": 33, "height": 33, "output": {"format": "png"},
            "toneMap": "linear", )" +
                           kPlainEffects + R"(, "camera": {"position": )" + eye +
                           R"(, "target": [0, 0, 0]})" + more + "}");
    if (!result || result->status != 200) {
        ADD_FAILURE() << (result ? result->body : "no answer");
        return {};
    }
    const Image image = decodePng(result->body);
    const std::uint8_t* p = image.bytes() + (16 * 33 + 16) * image.channels;
    return {{p[0] / 255.0f, p[1] / 255.0f, p[2] / 255.0f}, result->body};
}

std::string ownMap(const std::string& rotation, const std::string& more = "") {
    return R"(, "overrides": [{"material": "mirror", "environmentMap": "six-colours",
                "environmentRotation": )" +
           rotation + more + "}]";
}

void expectColor(const Seen& seen, int face, const std::string& about) {
    EXPECT_LT(glm::distance(seen.color, kColors[static_cast<std::size_t>(face)]), 0.02f) << about;
}

constexpr const char* kAhead = "[0, 0, 3]";      // mirrors +Z
constexpr const char* kFromRight = "[3, 0, 2]";  // mirrors what lies to the left
constexpr const char* kFromAbove = "[0, 3, 2]";  // mirrors what lies below

TEST(Maps, QuarterTurnsPermuteTheColouredWalls) {
    const std::string none = "[0, 0, 0, 1]";
    expectColor(seen("mirror", kAhead, ownMap(none)), 4, "ahead");
    expectColor(seen("mirror", kFromRight, ownMap(none)), 1, "from the right");
    expectColor(seen("mirror", kFromAbove, ownMap(none)), 3, "from above");
    // The world's +Z then shows the map's: -X, +X, +Y, -Y, -Z.
    const double q = 1.5707963267948966;
    const auto turned = [&](double x, double y) {
        return "[" + std::to_string(x) + ", " + std::to_string(y) + ", 0]";
    };
    expectColor(seen("mirror", kAhead, ownMap(turned(0, q))), 1, "a quarter about Y");
    expectColor(seen("mirror", kAhead, ownMap(turned(0, -q))), 0, "and back");
    expectColor(seen("mirror", kAhead, ownMap(turned(q, 0))), 2, "a quarter about X");
    expectColor(seen("mirror", kAhead, ownMap(turned(-q, 0))), 3, "and back");
    expectColor(seen("mirror", kAhead, ownMap(turned(0, 2 * q))), 5, "half about Y");
}

TEST(Maps, AllFormsOfARotationGiveTheSameBytes) {
    const std::string quaternion =
        seen("mirror", kAhead, ownMap("[0, 0.7071067811865476, 0, 0.7071067811865476]")).bytes;
    EXPECT_EQ(seen("mirror", kAhead, ownMap("[0, 0, -1, 0, 1, 0, 1, 0, 0]")).bytes, quaternion);
    EXPECT_EQ(seen("mirror", kAhead, ownMap("[0, 1.5707963267948966, 0]")).bytes, quaternion);
    const std::string environment = R"(, "environment": {"map": "six-colours", "rotation": )";
    const std::string asked =
        seen("mirror", kAhead, environment + "[0, 0, -1, 0, 1, 0, 1, 0, 0]}").bytes;
    EXPECT_EQ(seen("mirror", kAhead, environment + "[0, 1.5707963267948966, 0]}").bytes, asked);
    EXPECT_NE(seen("mirror", kAhead, environment + "[0, 0, 0, 1]}").bytes, asked);
}

TEST(Maps, ASceneMayRotateItsMapPermanently) {
    // A quarter about +Y: the world's +Z is the map's -X, unless a request says otherwise.
    expectColor(seen("turned", kAhead, ""), 1, "the scene's own");
    expectColor(seen("turned", kAhead, R"(, "environment": {"rotation": [0, 0, 0, 1]})"), 4,
                "the request's");
    auto client = server().client();
    const json scene = json::parse(client.Get("/v1/scenes/turned")->body);
    EXPECT_EQ(scene["environment"], "six-colours");
    EXPECT_NEAR(scene["environmentRotation"][1].get<double>(), std::sqrt(0.5), 1e-9);
}

TEST(Maps, AMissingMapGivesTheDefaultSkyAndAWarning) {
    seen("lost", kAhead, "");
    auto client = server().client();
    const json scene = json::parse(client.Get("/v1/scenes/lost")->body);
    EXPECT_EQ(scene["environment"], "sky");
    EXPECT_THAT(scene["warnings"].dump(), testing::HasSubstr("nowhere"));
}

TEST(Maps, ABlurAppearsInThePlanAndInTheImage) {
    // The pixel at which the wide view shows the edge between two colours.
    const std::string none = "[0, 0.3826834323650898, 0, 0.9238795325112867]";
    const Seen sharp = seen("mirror", kAhead, ownMap(none));
    const Seen soft =
        seen("mirror", kAhead, ownMap(none, R"(, "mapBlur": {"size": 6, "stdev": 2})"));
    EXPECT_NE(sharp.bytes, soft.bytes);
    EXPECT_EQ(seen("mirror", kAhead, ownMap(none, R"(, "mapBlur": {"size": 0, "stdev": 2})")).bytes,
              sharp.bytes);
    auto client = server().client();
    problemOf(postJson(client, "/v1/frames",
                       R"({"scene": "mirror", "overrides": [{"material": "mirror",
                           "mapBlur": {"size": 65, "stdev": -1}}]})"),
              422);
    for (const char* rotation :
         {"[1, 2]", "[0, 0, 0, 2]", "[1, 0, 0, 0, 1, 0, 0, 0, -1]", "\"x\"", "[0, 0, \"a\"]"}) {
        const json problem =
            problemOf(postJson(client, "/v1/frames",
                               R"({"scene": "mirror", "environment": {"rotation": )" +
                                   std::string(rotation) + "}}"),
                      422);
        EXPECT_THAT(problem["errors"][0]["pointer"].get<std::string>(),
                    testing::StartsWith("/environment/rotation"));
    }
}

TEST(Maps, AnInvalidMapFilePrintsOneLine) {
    for (const auto& [name, content, words] :
         {std::tuple("bad.ktx2", std::string("\xABKTX 20\xBB\r\n\x1A\n", 12), "cut short"),
          std::tuple("bad.exr", std::string("v/1\x01"), "damaged")}) {
        Config config = testConfig();
        config.scenes.environments = {writtenFile(name, content)};
        try {
            TestServer refused(config);
            ADD_FAILURE() << name << " was taken";
        } catch (const std::exception& error) {
            EXPECT_THAT(error.what(), testing::HasSubstr(words)) << name;
        }
    }
}

}  // namespace
}  // namespace clerestory::test
