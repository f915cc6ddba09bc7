// Layers: what flat and curved mirrors reflect and what is seen through glass, compared with
// arithmetic and with the mirrored scene.
#include "layer_support.h"

#include <cmath>

namespace clerestory::test {
namespace {

class Layers : public GlTest {};

TEST_F(Layers, AFlatMirrorShowsTheMirroredPoint) {
    const FrameRequest r = mirrorAndSquare();
    const Image id = layer(r, Channel::objectId, OutputLayer::reflected);
    const Image depth = layer(r, Channel::depth, OutputLayer::reflected);
    const Image position = layer(r, Channel::position, OutputLayer::reflected);
    const Image normal = layer(r, Channel::normal, OutputLayer::reflected);
    const Image albedo = layer(r, Channel::albedo, OutputLayer::reflected);
    const Image material = layer(r, Channel::materialId, OutputLayer::reflected);
    const Image direct = layer(r, Channel::objectId, OutputLayer::direct);
    ASSERT_EQ(id.channels, 1u);
    ASSERT_EQ(position.channels, 3u);
    std::size_t seen = 0;
    for (std::uint32_t y = 0; y < 64; ++y) {
        for (std::uint32_t x = 0; x < 64; ++x) {
            // The mirrored square is in the plane z = -3, 5 m from the eye.
            const double toX = 5.0 * (x - 31.5) / 32.0, toY = 5.0 * (31.5 - y) / 32.0;
            const bool inside = std::abs(toX - 0.25) < 1.0 && std::abs(toY - 0.5) < 1.0;
            const bool mirror = number(direct, x, y) == 1.0f;
            ASSERT_EQ(number(id, x, y), inside && mirror ? 2.0f : 0.0f) << x << ", " << y;
            ASSERT_EQ(number(material, x, y), inside && mirror ? 2.0f : 0.0f);
            if (!inside || !mirror) continue;
            ++seen;
            ASSERT_NEAR(number(depth, x, y), 5.0f, 1e-5f);
            ASSERT_LT(glm::length(color(position, x, y) - glm::vec3(toX, toY, 3.0)), 1e-5f);
            ASSERT_LT(glm::length(color(normal, x, y) - glm::vec3(0, 0, -1)), 1e-6f);
            ASSERT_LT(glm::length(color(albedo, x, y) - glm::vec3(0.5, 0.25, 0.125)), 1e-6f);
        }
    }
    EXPECT_GT(seen, 100u);
    EXPECT_EQ(number(layer(r, Channel::objectId, OutputLayer::refracted), 32, 20), 0.0f)
        << "no glass";
}

TEST_F(Layers, AMirroredBallIsMetOnItsSphere) {
    // A mirror ball at the origin inside of a large square at z = 4 behind the eye at z = 2.
    Scene scene;
    const Index mirror = addMaterial(scene, mirrorMetal());
    place(scene, sphere(0.5f, 96, mirror));
    place(scene, quad(100.0f, addMaterial(scene, {})), facingBack(0, 0, 4.0));
    const FrameRequest r = request(std::move(scene), "ball and wall");
    const Image position = layer(r, Channel::position, OutputLayer::reflected);
    const Image id = layer(r, Channel::objectId, OutputLayer::reflected);
    std::size_t seen = 0;
    for (std::uint32_t y = 0; y < 64; ++y) {
        for (std::uint32_t x = 0; x < 64; ++x) {
            const glm::dvec3 eye(0, 0, 2);
            const glm::dvec3 ray =
                glm::normalize(glm::dvec3((x - 31.5) / 32.0, (31.5 - y) / 32.0, -1.0));
            const double b = glm::dot(eye, ray), inside = b * b - glm::dot(eye, eye) + 0.25;
            if (inside < 0.01) continue;
            const glm::dvec3 at = eye + (-b - std::sqrt(inside)) * ray;
            const glm::dvec3 away = glm::reflect(ray, glm::normalize(at));
            if (away.z < 0.3) continue;
            const glm::dvec3 met = at + (4.0 - at.z) / away.z * away;
            ++seen;
            ASSERT_EQ(number(id, x, y), 2.0f);
            // Flat patches with interpolated normals.
            ASSERT_LT(glm::length(glm::dvec3(color(position, x, y)) - met),
                      0.02 * glm::length(met - at))
                << x << ", " << y;
        }
    }
    EXPECT_GT(seen, 50u);
}

TEST_F(Layers, APaneIsSeenStraightThrough) {
    const FrameRequest r = glassBefore(false);
    EXPECT_EQ(number(layer(r, Channel::objectId, OutputLayer::direct), 40, 20), 1.0f);
    EXPECT_EQ(number(layer(r, Channel::objectId, OutputLayer::refracted), 40, 20), 2.0f);
    EXPECT_NEAR(number(layer(r, Channel::depth, OutputLayer::refracted), 40, 20), 4.0f, 1e-5f);
    const glm::vec3 p = color(layer(r, Channel::position, OutputLayer::refracted), 40, 20);
    EXPECT_LT(glm::length(p - glm::vec3(4.0 * 8.5 / 32.0, 4.0 * 11.5 / 32.0, -2.0)), 1e-5f);
    EXPECT_EQ(number(layer(r, Channel::objectId, OutputLayer::refracted), 2, 2), 0.0f)
        << "outside of the pane, where the square is seen directly";
}

TEST_F(Layers, ABlockShiftsWhatIsSeenBySnell) {
    const FrameRequest r = glassBefore(true);
    const Image position = layer(r, Channel::position, OutputLayer::refracted);
    const Image id = layer(r, Channel::objectId, OutputLayer::refracted);
    std::size_t seen = 0;
    for (std::uint32_t x = 16; x < 48; ++x) {
        const double slope = (x - 31.5) / 32.0, down = (31.5 - 32.0) / 32.0;
        const double tangent = std::hypot(slope, down);
        const double sine = tangent / std::sqrt(1.0 + tangent * tangent) / 1.5;
        const double inside = sine / std::sqrt(1.0 - sine * sine);
        // 1.5 m of air before the block, 1 m of glass, 1.5 m of air behind it.
        const double radius = 3.0 * tangent + inside;
        ASSERT_EQ(number(id, x, 32), 2.0f) << x;
        const glm::vec3 p = color(position, x, 32);
        ASSERT_NEAR(p.x, radius * slope / tangent, 1e-5) << x;
        ASSERT_NEAR(p.y, radius * down / tangent, 1e-5);
        ++seen;
    }
    EXPECT_EQ(seen, 32u);
}

// ---- instances ---------------------------------------------------------------------------------

std::vector<LabelledInstance> instancesOf(FrameRequest r, OutputLayer which) {
    r.output.channel = Channel::instances;
    r.output.format = OutputFormat::json;
    r.output.layer = which;
    return renderer().render(r).instances;
}

// A mirror, and behind the eye a small square before a large one.
FrameRequest mirrorAndSquares(bool small) {
    Scene scene;
    place(scene, quad(1.5f, addMaterial(scene, mirrorMetal())));
    const Index plain = addMaterial(scene, {});
    place(scene, quad(1.0f, plain), facingBack(0.25, 0.5, 3.5));
    if (small) place(scene, quad(0.5f, plain), facingBack(0.25, 0.5, 3.0));
    return request(std::move(scene), small ? "mirror and squares" : "mirror and one square");
}

TEST_F(Layers, InstancesInAMirrorAreCountedAloneAndTogether) {
    const FrameRequest both = mirrorAndSquares(true), one = mirrorAndSquares(false);
    const auto together = instancesOf(both, OutputLayer::reflected);
    const auto alone = instancesOf(one, OutputLayer::reflected);
    ASSERT_EQ(together.size(), 2u);
    ASSERT_EQ(alone.size(), 1u);
    const Image id = layer(both, Channel::objectId, OutputLayer::reflected);
    for (const LabelledInstance& instance : together) {
        std::uint32_t pixels = 0, left = 64, top = 64, right = 0, bottom = 0;
        for (std::uint32_t y = 0; y < 64; ++y) {
            for (std::uint32_t x = 0; x < 64; ++x) {
                if (number(id, x, y) != static_cast<float>(instance.extent.instance + 1)) continue;
                ++pixels;
                left = std::min(left, x), right = std::max(right, x);
                top = std::min(top, y), bottom = std::max(bottom, y);
            }
        }
        EXPECT_EQ(instance.extent.pixels, pixels);
        EXPECT_EQ(instance.extent.box.x, left);
        EXPECT_EQ(instance.extent.box.y, top);
        EXPECT_EQ(instance.extent.box.width, right - left + 1);
        EXPECT_EQ(instance.extent.box.height, bottom - top + 1);
    }
    EXPECT_EQ(alone[0].extent.pixels, alone[0].extent.pixelsAlone);
    EXPECT_EQ(together[0].extent.pixelsAlone, alone[0].extent.pixels);
    EXPECT_EQ(together[0].extent.boxAlone.width, alone[0].extent.box.width);
    EXPECT_EQ(together[0].extent.pixels, alone[0].extent.pixels - together[1].extent.pixels);
    EXPECT_EQ(together[1].extent.pixels, together[1].extent.pixelsAlone);
    EXPECT_TRUE(instancesOf(both, OutputLayer::refracted).empty()) << "no glass";
}

TEST_F(Layers, InstancesBehindGlassAreThoseOfTheObjectIds) {
    const FrameRequest r = glassBefore(true);
    const auto instances = instancesOf(r, OutputLayer::refracted);
    ASSERT_EQ(instances.size(), 1u);
    const Image id = layer(r, Channel::objectId, OutputLayer::refracted);
    std::uint32_t pixels = 0;
    for (std::uint32_t y = 0; y < 64; ++y) {
        for (std::uint32_t x = 0; x < 64; ++x) pixels += number(id, x, y) == 2.0f;
    }
    EXPECT_EQ(instances[0].extent.pixels, pixels);
    EXPECT_EQ(instances[0].extent.pixelsAlone, pixels);
}

// ---- normal maps -------------------------------------------------------------------------------

// A normal map of one slope turns what a mirror shows by twice its angle.
TEST_F(Layers, BumpsTurnWhatAMirrorShows) {
    Scene scene;
    const glm::u8vec4 bumpTexel(153, 128, 248, 255);
    Material metal = mirrorMetal();
    metal.normalTexture.texture =
        addTexture2x2(scene, {bumpTexel, bumpTexel, bumpTexel, bumpTexel}, Wrap::repeat);
    const glm::dvec3 bump =
        glm::normalize(glm::dvec3(153, 128, 248) / 255.0 * 2.0 - glm::dvec3(1.0));
    place(scene, quad(1.5f, addMaterial(scene, metal)));
    place(scene, quad(100.0f, addMaterial(scene, {})), facingBack(0, 0, 4.0));
    const FrameRequest r = request(std::move(scene), "bumpy mirror");
    const Image position = layer(r, Channel::position, OutputLayer::reflected);
    for (const std::uint32_t x : {20u, 32u, 40u}) {
        const glm::dvec3 ray =
            glm::normalize(glm::dvec3((x - 31.5) / 32.0, (31.5 - 30.0) / 32.0, -1.0));
        const glm::dvec3 at = glm::dvec3(0, 0, 2) + 2.0 / -ray.z * ray;
        const glm::dvec3 away = glm::reflect(ray, bump);
        const glm::dvec3 met = at + 4.0 / away.z * away;
        EXPECT_LT(glm::length(glm::dvec3(color(position, x, 30)) - met), 1e-3) << x;
    }
}

TEST_F(Layers, ChannelsWithoutLayersAreRefused) {
    FrameRequest r = glassBefore(false);
    for (const Channel channel : {Channel::color, Channel::through}) {
        r.output.channel = channel;
        r.output.layer = OutputLayer::reflected;
        try {
            renderer().render(r);
            FAIL();
        } catch (const InvalidRequest& error) {
            ASSERT_EQ(error.errors().size(), 1u);
            EXPECT_EQ(error.errors()[0].pointer, "/output/layer");
        }
    }
}

}  // namespace
}  // namespace clerestory::test
