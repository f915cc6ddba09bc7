// Optical flow of what mirrors and glass show: arithmetic, and the same point in both frames.
#include "layer_support.h"
#include "scene/builtin/builtin_scenes.h"

#include <cmath>

namespace clerestory::test {
namespace {

class LayerFlow : public GlTest {};

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

// Calls act(x, y, flow) for each pixel with flow. Returns the number of pixels that show something.
template <class Act>
std::size_t forEachFlow(const Image& flow, const Image& id, const Act& act) {
    std::size_t shown = 0;
    for (std::uint32_t y = 0; y < flow.height; ++y) {
        for (std::uint32_t x = 0; x < flow.width; ++x) {
            if (number(id, x, y) == 0.0f) continue;
            ++shown;
            const glm::vec3 f = color(flow, x, y);
            if (f.z != 0.0f) act(x, y, f);
        }
    }
    return shown;
}

// A mirrored point moves as the point behind the mirror would.
TEST_F(LayerFlow, FlowInAFlatMirrorIsThatOfTheMirroredPoint) {
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
    std::size_t seen = 0;
    const std::size_t shown =
        forEachFlow(flow, id, [&](std::uint32_t x, std::uint32_t y, const glm::vec3& f) {
            // Between the centres of four pixels of the surface.
            const double px = x + f.x, py = y + f.y;
            const double left = std::floor(px), top = std::floor(py);
            if (left < 0 || top < 0 || left + 1 >= r.width || top + 1 >= r.height) return;
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
            if (!same || extent > 0.5) return;  // too curved for a linear mean
            ++seen;
            ASSERT_LT(glm::length(mean - glm::dvec3(color(from, x, y))), 0.25 * extent + 1e-4)
                << x << ", " << y << " of " << r.scene;
        });
    std::printf("%s: %zu of %zu pixels have the same point in the other frame\n", r.scene.c_str(),
                seen, shown);
    EXPECT_GE(seen, atLeast);
}

// A wall with much of its surface at right angles to each ray, beyond or behind a ball.
FrameRequest ballAndWall(const Material& material, double wall) {
    Scene scene;
    place(scene, sphere(0.8f, 96, addMaterial(scene, material)));
    place(scene, quad(8.0f, addMaterial(scene, {})),
          wall > 0.0 ? facingBack(0, 0, wall) : moved(0, 0, wall));
    FrameRequest r = request(std::move(scene), wall > 0.0 ? "mirror ball" : "glass ball");
    r.width = r.height = 192;
    return r;
}

TEST_F(LayerFlow, FlowInACurvedMirrorLeadsToTheSamePoint) {
    expectFlowLeadsToThePoint(ballAndWall(mirrorMetal(), 4.0), OutputLayer::reflected,
                              {0.1, 0.05, 0.05}, 1000);
}

TEST_F(LayerFlow, FlowThroughABallOfGlassLeadsToTheSamePoint) {
    Material glass = clearGlass();
    glass.thickness = 1.6f;
    expectFlowLeadsToThePoint(ballAndWall(glass, -3.0), OutputLayer::refracted, {0.1, 0.05, 0.05},
                              3000);
}

TEST_F(LayerFlow, FlowThroughABlockLeadsToTheSamePoint) {
    expectFlowLeadsToThePoint(glassBefore(true), OutputLayer::refracted, {0.2, 0.1, -0.1}, 300);
}

TEST_F(LayerFlow, FlowOfWhatIsAtRestIsZero) {
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
TEST_F(LayerFlow, FlowFollowsMovingMirrorsAndWhatTheyShow) {
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
    std::size_t followed = 0, met = 0, moved = 0;
    const std::size_t shown =
        forEachFlow(flow, id, [&](std::uint32_t x, std::uint32_t y, const glm::vec3& f) {
            ++followed;
            moved += glm::length(glm::vec2(f)) > 0.5f;
            const double px = std::floor(x + 0.5 + f.x), py = std::floor(y + 0.5 + f.y);
            if (px < 0 || py < 0 || px >= r.width || py >= r.height) return;
            const auto cx = static_cast<std::uint32_t>(px), cy = static_cast<std::uint32_t>(py);
            met += number(idThere, cx, cy) == number(id, x, y) &&
                   std::abs(number(depth, cx, cy) - f.z) < 0.03f * f.z;
        });
    std::printf("%zu pixels of mirrors, %zu followed, %zu met again, %zu moved\n", shown, followed,
                met, moved);
    renderer().removeScene(r.scene);
    EXPECT_GT(shown, 500u);
    EXPECT_GT(moved, 50u);
    EXPECT_GT(followed, shown * 8 / 10);
    EXPECT_GT(met, followed * 8 / 10);
}

}  // namespace
}  // namespace clerestory::test
