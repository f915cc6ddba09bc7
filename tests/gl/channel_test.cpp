// Data channels (depth, normals, ids) compared with the geometry.
#include "support.h"

#include <cmath>

using namespace clerestory;
using namespace clerestory::test;

namespace {

class Channels : public GlTest {};

Image channel(FrameRequest r, Channel which) {
    r.output.channel = which;
    return renderer().render(r).image;
}

// A tilted plane in the left half, a mirrored one in the right half.
FrameRequest tilted() {
    Scene scene;
    const Index m = addMaterial(scene, {});
    glm::dmat4 a = moved(-1.0, 0, 0);  // turned about X
    a[1] = {0, std::cos(0.5), std::sin(0.5), 0};
    a[2] = {0, -std::sin(0.5), std::cos(0.5), 0};
    glm::dmat4 b = moved(1.0, 0, -1.0);
    b[0][0] = -3.0;
    place(scene, quad(0.8f, m), a);
    place(scene, quad(0.8f, m), b);
    return request(std::move(scene), "tilted", {0, 0, 2});
}

}  // namespace

TEST_F(Channels, DepthIsMetresAlongTheViewDirection) {
    const Image image = channel(tilted(), Channel::depth);
    ASSERT_EQ(image.channels, 1u);
    for (std::uint32_t y = 24; y < 40; ++y) {
        // The pixel's ray: (.., (31.5 - y) / 32, -1) times depth; the plane: z = y tan(0.5).
        const double slope = (31.5 - y) / 32.0, tangent = std::tan(0.5);
        // 2 - depth = depth * slope * tangent
        const double expected = 2.0 / (1.0 + slope * tangent);
        EXPECT_NEAR(number(image, 16, y), expected, 1e-5 * expected) << y;
    }
    EXPECT_NEAR(number(image, 44, 32), 3.0f, 1e-5f);
    EXPECT_EQ(number(image, 32, 1), 0.0f) << "background";
}

TEST_F(Channels, NormalsAreUnitAndInWorldSpace) {
    const Image image = channel(tilted(), Channel::normal);
    ASSERT_EQ(image.channels, 3u);
    const glm::vec3 a = color(image, 16, 32), b = color(image, 44, 32);
    EXPECT_NEAR(a.x, 0.0f, 1e-6f);
    EXPECT_NEAR(a.y, -std::sin(0.5f), 1e-6f);
    EXPECT_NEAR(a.z, std::cos(0.5f), 1e-6f);
    EXPECT_NEAR(glm::length(b - glm::vec3(0, 0, 1)), 0.0f, 1e-6f) << "mirrored and stretched";
    EXPECT_EQ(color(image, 32, 1), glm::vec3(0.0f));
}

TEST_F(Channels, ObjectIdsAreInstancesStartingAtOne) {
    const Image image = channel(tilted(), Channel::objectId);
    ASSERT_EQ(image.channels, 1u);
    EXPECT_EQ(number(image, 16, 32), 1.0f);
    EXPECT_EQ(number(image, 44, 32), 2.0f);
    EXPECT_EQ(number(image, 32, 1), 0.0f);
}

TEST_F(Channels, MaskedTexelsAreHoles) {
    Scene scene;
    Material m;
    m.alphaMode = AlphaMode::mask;
    m.baseColorTexture.texture =
        addTexture2x2(scene, {glm::u8vec4(0), glm::u8vec4(255), glm::u8vec4(255), glm::u8vec4(255)},
                      Wrap::clampToEdge);
    place(scene, quad(1.0f, addMaterial(scene, m)));
    const Image image = channel(request(std::move(scene), "holes"), Channel::objectId);
    EXPECT_EQ(number(image, 24, 24), 0.0f);
    EXPECT_EQ(number(image, 40, 24), 1.0f);
}

TEST_F(Channels, TheNearestSurfaceIsShown) {
    Scene scene;
    const Index m = addMaterial(scene, {});
    Material veil;
    veil.alphaMode = AlphaMode::blend;
    veil.baseColor.w = 0.1f;
    place(scene, quad(1.0f, m));
    place(scene, quad(0.25f, addMaterial(scene, veil)), moved(0, 0, 1));
    const Image image = channel(request(std::move(scene), "nearest"), Channel::depth);
    EXPECT_NEAR(number(image, 32, 32), 1.0f, 1e-5f);
    EXPECT_NEAR(number(image, 18, 18), 2.0f, 1e-5f);
}

TEST_F(Channels, DepthResolvesAMillionthOfTheDistance) {
    // Two planes a tenth of a millimetre apart, a hundred metres away, near plane at a centimetre.
    Scene scene;
    const Index m = addMaterial(scene, {});
    place(scene, quad(50.0f, m), moved(0, 0, -100));
    place(scene, quad(50.0f, m), moved(0, 0, -100.0001));
    const Image image =
        channel(request(std::move(scene), "close planes", {0, 0, 0}), Channel::objectId);
    for (std::uint32_t y = 20; y < 44; ++y) {
        for (std::uint32_t x = 20; x < 44; ++x) ASSERT_EQ(number(image, x, y), 1.0f);
    }
}

TEST_F(Channels, PositionsAreWorldMetres) {
    // The point at depth d of a pixel: eye + d (x, y, -1), as docs/camera.md says.
    for (const double away : {0.0, 1000.0}) {
        Scene scene;
        place(scene, quad(1.0f, addMaterial(scene, {})), moved(away, 0.25, -away));
        FrameRequest r = request(std::move(scene), "positions", {away + 0.5, 0, 2.0 - away});
        const Image image = channel(r, Channel::position), depth = channel(r, Channel::depth);
        ASSERT_EQ(image.channels, 3u);
        const double step = 1e-6 * std::max(2.0, away);
        std::size_t seen = 0;
        for (std::uint32_t y = 0; y < 64; ++y) {
            for (std::uint32_t x = 0; x < 64; ++x) {
                const double d = number(depth, x, y);
                const glm::vec3 p = color(image, x, y);
                if (d == 0.0) {
                    ASSERT_EQ(p, glm::vec3(0.0f)) << "background";
                    continue;
                }
                ++seen;
                ASSERT_NEAR(p.x, away + 0.5 + d * (x - 31.5) / 32.0, step);
                ASSERT_NEAR(p.y, d * (31.5 - y) / 32.0, step);
                ASSERT_NEAR(p.z, -away, step);
            }
        }
        EXPECT_NEAR(static_cast<double>(seen), 32.0 * 32.0, 70.0);
    }
}

TEST_F(Channels, AlbedoIsFactorTimesTextureTimesVertexColour) {
    Scene scene;
    Material m;
    m.baseColor = {0.5f, 0.25f, 1.0f, 1.0f};
    m.metallic = 1.0f;  // the base colour of glTF, not the diffuse share
    m.emissive = glm::vec3(3.0f);
    m.baseColorTexture.texture =
        addTexture2x2(scene,
                      {glm::u8vec4(255, 0, 0, 255), glm::u8vec4(0, 255, 0, 255), glm::u8vec4(255),
                       glm::u8vec4(188, 188, 188, 255)},
                      Wrap::clampToEdge);
    scene.images.back().colorSpace = ColorSpace::srgb;
    MeshDraft draft = quad(1.0f, addMaterial(scene, m));
    for (Vertex& v : draft.vertices) v.color = {1.0f, 0.5f, 0.25f, 1.0f};
    place(scene, draft);
    const Image image = channel(request(std::move(scene), "albedo"), Channel::albedo);
    ASSERT_EQ(image.channels, 3u);
    const auto isNear = [&](std::uint32_t x, std::uint32_t y, const glm::vec3& wanted) {
        EXPECT_LT(glm::length(color(image, x, y) - wanted), 1e-3f) << x << ", " << y;
    };
    const glm::vec3 plain(0.5f, 0.125f, 0.25f);
    isNear(24, 24, {0.5f, 0.0f, 0.0f});
    isNear(40, 24, {0.0f, 0.125f, 0.0f});
    isNear(24, 40, plain);
    const float half = std::pow((188.0f / 255.0f + 0.055f) / 1.055f, 2.4f);
    isNear(40, 40, plain * half);
    EXPECT_EQ(color(image, 2, 2), glm::vec3(0.0f)) << "background";
}

namespace {

// Two squares side by side below one node each, of different materials.
Scene twoSquares() {
    Scene scene;
    const Index first = addMaterial(scene, {.name = "unused"}), left = addMaterial(scene, {});
    scene.materials[first].name = "unused";
    scene.materials[left].name = "left";
    Material glass = clearGlass();
    glass.name = "right";
    const Index right = addMaterial(scene, glass);
    place(scene, quad(0.5f, right), moved(0.75, 0, 0));
    scene.nodes.back().name = "car 7";
    place(scene, quad(0.5f, left), moved(-0.75, 0, 0));
    scene.nodes.back().name = "wheel";
    return scene;
}

}  // namespace

TEST_F(Channels, MaterialIdsAreThoseOfTheScene) {
    FrameRequest r = request(twoSquares(), "materials");
    Image image = channel(r, Channel::materialId);
    ASSERT_EQ(image.channels, 1u);
    EXPECT_EQ(number(image, 20, 32), 2.0f);
    EXPECT_EQ(number(image, 44, 32), 3.0f) << "glass";
    EXPECT_EQ(number(image, 32, 2), 0.0f);
    r.overrides = {{.material = "left", .baseColor = glm::dvec3(1.0)}};
    EXPECT_EQ(channel(r, Channel::materialId).data, image.data) << "overridden";
}

TEST_F(Channels, ClassesFollowTheNamesOfNodes) {
    FrameRequest r = request(twoSquares(), "classes");
    r.output.classes = {{"vehicle", "car*"}, {"part", "w*l"}};
    Image image = channel(r, Channel::classId);
    ASSERT_EQ(image.channels, 1u);
    EXPECT_EQ(number(image, 44, 32), 1.0f);
    EXPECT_EQ(number(image, 20, 32), 2.0f);
    EXPECT_EQ(number(image, 32, 2), 0.0f);
    r.output.classes = {{"vehicle", "car*"}};
    image = channel(r, Channel::classId);
    EXPECT_EQ(number(image, 44, 32), 1.0f);
    EXPECT_EQ(number(image, 20, 32), 0.0f) << "no class";
    r.output.classes.push_back({"boat", "ship*"});
    try {
        channel(r, Channel::classId);
        FAIL();
    } catch (const InvalidRequest& error) {
        ASSERT_EQ(error.errors().size(), 1u);
        EXPECT_EQ(error.errors()[0].pointer, "/output/classes/1/pattern");
    }
}

TEST_F(Channels, LabelsAndPositionsOfAPanoramaAreThoseOfItsViews) {
    FrameRequest r = request(twoSquares(), "panorama of labels", {0.5, 0, 2});
    r.camera.yfov.reset();
    r.camera.lens = EquirectangularLens{};
    const Image id = channel(r, Channel::materialId), position = channel(r, Channel::position);
    std::size_t seen = 0;
    for (std::uint32_t y = 0; y < id.height; ++y) {
        for (std::uint32_t x = 0; x < id.width; ++x) {
            if (number(id, x, y) == 0.0f) continue;
            ++seen;
            const glm::vec3 p = color(position, x, y);
            ASSERT_NEAR(p.z, 0.0f, 1e-5f);
            ASSERT_EQ(p.x < 0.0f ? 2.0f : 3.0f, number(id, x, y));
        }
    }
    EXPECT_GT(seen, 50u);
}
