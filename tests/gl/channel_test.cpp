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
