// Layers: what flat and curved mirrors reflect and what is seen through glass, compared with
// arithmetic and with the mirrored scene.
#include "scene/builtin/builtin_scenes.h"
#include "support.h"

#include <cmath>

namespace clerestory::test {
namespace {

class Layers : public GlTest {};

Image layer(FrameRequest r, Channel channel, OutputLayer which) {
    r.output.channel = channel;
    r.output.layer = which;
    return renderer().render(r).image;
}

// A mirror in the plane z = 0 and, behind the eye at z = 2, a square at z = 3 that faces it.
FrameRequest mirrorAndSquare() {
    Scene scene;
    const Index mirror = addMaterial(scene, mirrorMetal());
    Material red;
    red.baseColor = {0.5f, 0.25f, 0.125f, 1.0f};
    place(scene, quad(1.5f, mirror));
    glm::dmat4 turned = moved(0.25, 0.5, 3.0);  // about Y by half a turn
    turned[0] = {-1, 0, 0, 0};
    turned[2] = {0, 0, -1, 0};
    place(scene, quad(1.0f, addMaterial(scene, red)), turned);
    return request(std::move(scene), "mirror and square");
}

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
    glm::dmat4 turned = moved(0, 0, 4.0);
    turned[0] = {-1, 0, 0, 0};
    turned[2] = {0, 0, -1, 0};
    place(scene, quad(100.0f, addMaterial(scene, {})), turned);
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

// A pane before a square, or a solid block of glass.
FrameRequest glassBefore(bool solid) {
    Scene scene;
    Material glass = clearGlass();
    if (solid) glass.thickness = 1.0f;
    const Index material = addMaterial(scene, glass);
    if (solid) {
        MeshDraft block;
        block.name = "block";
        block.material = material;
        block.hasNormals = true;
        for (const double side : {1.0, -1.0}) {  // z = 0.5 and z = -0.5
            const auto first = static_cast<std::uint32_t>(block.vertices.size());
            for (const glm::vec2 corner :
                 {glm::vec2(-1, -1), glm::vec2(1, -1), glm::vec2(1, 1), glm::vec2(-1, 1)}) {
                Vertex v;
                v.position = glm::vec3(1.5f * corner, 0.5 * side);
                v.normal = glm::vec3(0, 0, side);
                block.vertices.push_back(v);
            }
            for (const std::uint32_t i :
                 side > 0 ? std::array{0u, 1u, 2u, 0u, 2u, 3u} : std::array{0u, 2u, 1u, 0u, 3u, 2u})
                block.indices.push_back(first + i);
        }
        place(scene, std::move(block));
    } else {
        place(scene, quad(1.5f, material));
    }
    place(scene, quad(2.0f, addMaterial(scene, {})), moved(0, 0, -2));
    return request(std::move(scene), solid ? "block" : "pane");
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

// ---- optical flow ------------------------------------------------------------------------------

Image flowOf(FrameRequest r, OutputLayer which, double time, const CameraRequest& camera) {
    r.output.channel = Channel::flow;
    r.output.layer = which;
    r.output.flow = FlowRequest{time, camera};
    return renderer().render(r).image;
}

CameraRequest shifted(CameraRequest camera, const glm::dvec3& by) {
    camera.position = *camera.position + by;
    if (camera.target) camera.target = *camera.target + by;
    return camera;
}

// A mirrored point moves as the point behind the mirror would.
TEST_F(Layers, FlowInAFlatMirrorIsThatOfTheMirroredPoint) {
    const FrameRequest r = mirrorAndSquare();
    const glm::dvec3 by(0.2, -0.1, 0.3);
    const Image flow = flowOf(r, OutputLayer::reflected, 0.0, shifted(r.camera, by));
    const Image position = layer(r, Channel::position, OutputLayer::reflected);
    const Image id = layer(r, Channel::objectId, OutputLayer::reflected);
    std::size_t seen = 0, lost = 0;
    for (std::uint32_t y = 0; y < 64; ++y) {
        for (std::uint32_t x = 0; x < 64; ++x) {
            const glm::dvec3 f(color(flow, x, y));
            if (number(id, x, y) == 0.0f) {
                ASSERT_EQ(f, glm::dvec3(0.0)) << x << ", " << y;
                continue;
            }
            const glm::dvec3 p(color(position, x, y));
            const glm::dvec3 behind = glm::dvec3(p.x, p.y, -p.z) - (glm::dvec3(0, 0, 2) + by);
            const glm::dvec2 to(32.0 + 32.0 * behind.x / -behind.z,
                                32.0 - 32.0 * behind.y / -behind.z);
            if (f.z == 0.0) {  // left the mirror
                ++lost;
                const glm::dvec3 eye = glm::dvec3(0, 0, 2) + by;
                const glm::dvec3 at = eye + eye.z / -behind.z * behind;
                ASSERT_GT(std::max(std::abs(at.x), std::abs(at.y)), 1.499) << x << ", " << y;
                continue;
            }
            ++seen;
            ASSERT_NEAR(f.x, to.x - (x + 0.5), 1e-3) << x << ", " << y;
            ASSERT_NEAR(f.y, to.y - (y + 0.5), 1e-3);
            ASSERT_NEAR(f.z, -behind.z, 1e-3);
        }
    }
    EXPECT_GT(seen, 100u);
    EXPECT_LT(lost, seen);
}

// What the other frame's layer has at the place of the flow is the same point.
void expectFlowLeadsToThePoint(const FrameRequest& r, OutputLayer which, const glm::dvec3& by,
                               std::size_t atLeast) {
    FrameRequest other = r;
    other.camera = shifted(r.camera, by);
    const Image flow = flowOf(r, which, 0.0, other.camera);
    const Image from = layer(r, Channel::position, which);
    const Image to = layer(other, Channel::position, which);
    const Image id = layer(r, Channel::objectId, which);
    const Image idThere = layer(other, Channel::objectId, which);
    std::size_t seen = 0, shown = 0;
    for (std::uint32_t y = 0; y < r.height; ++y) {
        for (std::uint32_t x = 0; x < r.width; ++x) {
            if (number(id, x, y) == 0.0f) continue;
            ++shown;
            const glm::vec3 f = color(flow, x, y);
            if (f.z == 0.0f) continue;
            // Between the centres of four pixels of the surface.
            const double px = x + f.x, py = y + f.y;
            const double left = std::floor(px), top = std::floor(py);
            if (left < 0 || top < 0 || left + 1 >= r.width || top + 1 >= r.height) continue;
            glm::dvec3 mean(0.0);
            double extent = 0.0;
            bool same = true;
            const auto corner = [&](int i) {
                const auto cx = static_cast<std::uint32_t>(left) + (i & 1);
                const auto cy = static_cast<std::uint32_t>(top) + (i >> 1);
                same = same && number(idThere, cx, cy) == number(id, x, y);
                return glm::dvec3(color(to, cx, cy));
            };
            for (int i = 0; i < 4; ++i) {
                const double w =
                    ((i & 1) ? px - left : 1 - px + left) * ((i >> 1) ? py - top : 1 - py + top);
                mean += w * corner(i);
                extent = std::max(extent, glm::length(corner(i) - corner(0)));
            }
            if (!same || extent > 0.5) continue;  // too curved for a linear mean
            ++seen;
            ASSERT_LT(glm::length(mean - glm::dvec3(color(from, x, y))), 0.25 * extent + 1e-4)
                << x << ", " << y << " of " << r.scene;
        }
    }
    std::printf("%s: %zu of %zu pixels have the same point in the other frame\n", r.scene.c_str(),
                seen, shown);
    EXPECT_GE(seen, atLeast);
}

// A wall with much of its surface at right angles to each ray, beyond or behind a ball.
FrameRequest ballAndWall(const Material& material, double wall) {
    Scene scene;
    place(scene, sphere(0.8f, 96, addMaterial(scene, material)));
    glm::dmat4 turned = moved(0, 0, wall);
    if (wall > 0.0) {
        turned[0] = {-1, 0, 0, 0};
        turned[2] = {0, 0, -1, 0};
    }
    place(scene, quad(8.0f, addMaterial(scene, {})), turned);
    FrameRequest r = request(std::move(scene), wall > 0.0 ? "mirror ball" : "glass ball");
    r.width = r.height = 192;
    return r;
}

TEST_F(Layers, FlowInACurvedMirrorLeadsToTheSamePoint) {
    expectFlowLeadsToThePoint(ballAndWall(mirrorMetal(), 4.0), OutputLayer::reflected,
                              {0.1, 0.05, 0.05}, 1000);
}

TEST_F(Layers, FlowThroughABallOfGlassLeadsToTheSamePoint) {
    Material glass = clearGlass();
    glass.thickness = 1.6f;
    expectFlowLeadsToThePoint(ballAndWall(glass, -3.0), OutputLayer::refracted, {0.1, 0.05, 0.05},
                              3000);
}

TEST_F(Layers, FlowThroughABlockLeadsToTheSamePoint) {
    expectFlowLeadsToThePoint(glassBefore(true), OutputLayer::refracted, {0.2, 0.1, -0.1}, 300);
}

TEST_F(Layers, FlowOfWhatIsAtRestIsZero) {
    Material glass = clearGlass();
    glass.thickness = 1.6f;
    for (const auto& [r, which] :
         {std::pair{ballAndWall(glass, -3.0), OutputLayer::refracted},
          std::pair{ballAndWall(mirrorMetal(), 4.0), OutputLayer::reflected},
          std::pair{mirrorAndSquare(), OutputLayer::reflected}}) {
        const Image flow = flowOf(r, which, 0.0, r.camera);
        const Image depth = layer(r, Channel::depth, which);
        for (std::uint32_t y = 0; y < r.height; ++y) {
            for (std::uint32_t x = 0; x < r.width; ++x) {
                const glm::vec3 f = color(flow, x, y);
                ASSERT_EQ(glm::vec2(f), glm::vec2(0.0f)) << x << ", " << y;
                ASSERT_NEAR(f.z, number(depth, x, y), 1e-4f * f.z) << x << ", " << y;
            }
        }
    }
}

// Everything moves and deforms: the other frame has the same instance at the same depth, unless
// another surface hides it there.
TEST_F(Layers, FlowFollowsMovingMirrorsAndWhatTheyShow) {
    Scene scene = *makeBuiltinScene("meadow");
    scene.id = "meadow in mirrors";
    renderer().addScene(std::move(scene));
    FrameRequest r;
    r.scene = "meadow in mirrors";
    r.width = 320;
    r.height = 180;
    r.time = 0.4;
    r.output.format = OutputFormat::npy;
    FrameRequest other = r;
    other.time = 0.45;
    const Image flow = flowOf(r, OutputLayer::reflected, other.time, r.camera);
    const Image id = layer(r, Channel::objectId, OutputLayer::reflected);
    const Image idThere = layer(other, Channel::objectId, OutputLayer::reflected);
    const Image depth = layer(other, Channel::depth, OutputLayer::reflected);
    std::size_t shown = 0, followed = 0, met = 0, moved = 0;
    for (std::uint32_t y = 0; y < r.height; ++y) {
        for (std::uint32_t x = 0; x < r.width; ++x) {
            if (number(id, x, y) == 0.0f) continue;
            ++shown;
            const glm::vec3 f = color(flow, x, y);
            if (f.z == 0.0f) continue;
            ++followed;
            moved += glm::length(glm::vec2(f)) > 0.5f;
            const double px = std::floor(x + 0.5 + f.x), py = std::floor(y + 0.5 + f.y);
            if (px < 0 || py < 0 || px >= r.width || py >= r.height) continue;
            const auto cx = static_cast<std::uint32_t>(px), cy = static_cast<std::uint32_t>(py);
            met += number(idThere, cx, cy) == number(id, x, y) &&
                   std::abs(number(depth, cx, cy) - f.z) < 0.03f * f.z;
        }
    }
    std::printf("%zu pixels of mirrors, %zu followed, %zu met again, %zu moved\n", shown, followed,
                met, moved);
    renderer().removeScene(r.scene);
    EXPECT_GT(shown, 500u);
    EXPECT_GT(moved, 50u);
    EXPECT_GT(followed, shown * 8 / 10);
    EXPECT_GT(met, followed * 8 / 10);
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
    const auto facing = [](double x, double y, double z) {
        glm::dmat4 turned = moved(x, y, z);
        turned[0] = {-1, 0, 0, 0};
        turned[2] = {0, 0, -1, 0};
        return turned;
    };
    place(scene, quad(1.0f, plain), facing(0.25, 0.5, 3.5));
    if (small) place(scene, quad(0.5f, plain), facing(0.25, 0.5, 3.0));
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
    glm::dmat4 turned = moved(0, 0, 4.0);
    turned[0] = {-1, 0, 0, 0};
    turned[2] = {0, 0, -1, 0};
    place(scene, quad(100.0f, addMaterial(scene, {})), turned);
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
