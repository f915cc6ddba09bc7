// Optical flow: arithmetic for a translating plane and a turning camera, deformed vertices, and one
// frame warped onto the next.
#include "plan/graph/projection.h"
#include "plan/visibility/view.h"
#include "scene/builtin/builtin_scenes.h"
#include "support.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace clerestory::test {
namespace {

class Flow : public GlTest {};

Image channel(FrameRequest r, Channel which) {
    r.output.channel = which;
    return renderer().render(r).image;
}

std::vector<FieldError> errorsOf(const FrameRequest& r) {
    try {
        channel(r, Channel::flow);
    } catch (const InvalidRequest& error) {
        return error.errors();
    }
    return {};
}

TEST_F(Flow, OfATranslatingPlaneIsArithmetic) {
    Scene scene;
    place(scene, quad(1.0f, addMaterial(scene, {})));
    moveLast(scene, {0, 0, 0}, {0.5f, 0.25f, -1.0f});
    FrameRequest r = request(std::move(scene), "translating");
    r.time = 0.5;
    r.output.flow = FlowRequest{.time = 1.5};
    const Image flow = channel(r, Channel::flow), depth = channel(r, Channel::depth);
    ASSERT_EQ(flow.channels, 3u);
    std::size_t seen = 0;
    for (std::uint32_t y = 0; y < 64; ++y) {
        for (std::uint32_t x = 0; x < 64; ++x) {
            const glm::vec3 f = color(flow, x, y);
            if (number(depth, x, y) == 0.0f) {
                ASSERT_EQ(f, glm::vec3(0.0f)) << "background";
                continue;
            }
            ++seen;
            // At the depth 2.25 at first, then at 2.75; 32 pixels to a unit of slope.
            const double fromX = 2.25 * (x - 31.5) / 32.0, fromY = 2.25 * (31.5 - y) / 32.0;
            ASSERT_NEAR(f.x, 32.0 * (fromX + 0.25) / 2.75 - (x - 31.5), 1e-5);
            ASSERT_NEAR(f.y, -32.0 * (fromY + 0.125) / 2.75 - (y - 31.5), 1e-5);
            ASSERT_NEAR(f.z, 2.75, 1e-6);
        }
    }
    EXPECT_GT(seen, 700u);
}

TEST_F(Flow, OfWhatStandsStillIsZero) {
    FrameRequest r;
    r.scene = "teapots";
    if (!renderer().hasScene(r.scene)) renderer().addScene(*makeBuiltinScene(r.scene));
    r.width = 96;
    r.height = 54;
    r.output.format = OutputFormat::npy;
    for (const bool lens : {false, true}) {
        if (lens) r.camera.lens = FisheyeLens{.fov = 0.8, .k1 = 0.05};
        r.output.flow = FlowRequest{.time = 3.0};
        const Image flow = channel(r, Channel::flow), depth = channel(r, Channel::depth);
        std::size_t seen = 0;
        for (std::uint32_t y = 0; y < r.height; ++y) {
            for (std::uint32_t x = 0; x < r.width; ++x) {
                const glm::vec3 f = color(flow, x, y);
                ASSERT_EQ(glm::vec2(f), glm::vec2(0.0f)) << x << ", " << y;
                const float d = number(depth, x, y);
                // The depth of a lens is that of the nearest sample, half a pixel away at most.
                if (lens) {
                    ASSERT_EQ(f.z > 0.0f, d > 0.0f);
                } else {
                    // Pixels are snapped to 1/256; a silhouette is steep.
                    ASSERT_NEAR(f.z, d, 1e-3 * d) << x << ", " << y;
                }
                seen += d > 0.0f;
            }
        }
        EXPECT_GT(seen, 1000u);
    }
}

TEST_F(Flow, OfATurningPanoramaIsItsAngle) {
    Scene scene;
    Material m;
    m.doubleSided = true;
    place(scene, sphere(5.0f, 32, addMaterial(scene, m)));
    FrameRequest r = request(std::move(scene), "turning", {0, 0, 0});
    r.camera.yfov.reset();
    r.camera.lens = EquirectangularLens{};
    r.width = 128;
    CameraRequest turned = r.camera;
    const double angle = -0.4;  // to the right
    turned.target = glm::dvec3(-std::sin(angle), 0.0, -std::cos(angle));
    r.output.flow = FlowRequest{.time = 0.0, .camera = turned};
    const Image flow = channel(r, Channel::flow);
    const double expected = -0.4 / (2.0 * std::numbers::pi) * 128.0;  // to the left
    for (std::uint32_t y = 0; y < r.height; ++y) {
        for (std::uint32_t x = 0; x < r.width; ++x) {
            const glm::vec3 f = color(flow, x, y);
            ASSERT_NEAR(f.x, expected, 1e-4) << x << ", " << y;  // across the seam, too
            ASSERT_NEAR(f.y, 0.0, 1e-4);
            ASSERT_NEAR(f.z, 5.0, 0.03);  // flat patches
        }
    }
}

TEST_F(Flow, OfPointsBehindTheOtherCameraIsNone) {
    Scene scene;
    place(scene, quad(1.0f, addMaterial(scene, {})));
    FrameRequest r = request(std::move(scene), "behind");
    CameraRequest away = r.camera;
    away.target = *away.position + glm::dvec3(0, 0, 1);
    r.output.flow = FlowRequest{.time = 0.0, .camera = away};
    const Image flow = channel(r, Channel::flow);
    EXPECT_EQ(number(channel(r, Channel::objectId), 32, 32), 1.0f);
    EXPECT_TRUE(std::all_of(flow.floats(), flow.floats() + std::size_t{3} * 64 * 64,
                            [](float f) { return f == 0.0f; }));
}

// The meadow: a skinned fox and grass and water of morph targets.
FrameRequest meadow(double time) {
    FrameRequest r;
    r.scene = "meadow";
    if (!renderer().hasScene(r.scene)) renderer().addScene(*makeBuiltinScene(r.scene));
    r.width = 320;
    r.height = 180;
    r.time = time;
    r.output.format = OutputFormat::npy;
    return r;
}

TEST_F(Flow, FollowsSkinsAndMorphTargets) {
    FrameRequest r = meadow(0.2);
    const double later = 0.3;
    r.output.flow = FlowRequest{.time = later};
    const Image flow = channel(r, Channel::flow), depth = channel(r, Channel::depth);
    const Image id = channel(r, Channel::objectId);
    const Scene scene = *makeBuiltinScene("meadow");
    const Pose before = poseAt(scene, r.time), after = poseAt(scene, later);
    const Projection p{
        requestedView(r.camera, scene, before, r.width, r.height), {}, r.width, r.height};
    std::size_t skinned = 0, morphed = 0;
    double farthest = 0.0;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        const Mesh& mesh = scene.meshes[instance.mesh];
        if (mesh.deformation == kNone) continue;
        const Deformation& d = scene.deformations[mesh.deformation];
        for (std::uint32_t v = d.firstVertex; v < d.firstVertex + d.base.size(); ++v) {
            const auto at = [&](const Pose& pose) {
                const glm::dvec3 model(verticesOf(scene, pose, mesh)[v].position);
                return projected(
                    p, glm::dvec3(pose.worldFromNode[instance.node] * glm::dvec4(model, 1.0)));
            };
            const auto from = at(before), to = at(after);
            if (!from || !to) continue;
            const glm::dvec2 pixel = glm::floor(from->pixel);
            if (pixel.x < 0 || pixel.y < 0 || pixel.x >= r.width || pixel.y >= r.height) continue;
            const auto x = static_cast<std::uint32_t>(pixel.x);
            const auto y = static_cast<std::uint32_t>(pixel.y);
            if (number(id, x, y) != static_cast<float>(i + 1)) continue;
            if (std::abs(number(depth, x, y) - from->depth) > 2e-3 * from->depth) continue;
            // The pixel's centre is at most 0.71 pixels away from the vertex.
            const glm::dvec2 wanted = to->pixel - from->pixel;
            const glm::dvec2 error = glm::dvec2(color(flow, x, y)) - wanted;
            EXPECT_LT(glm::length(error), 0.3) << x << ", " << y;
            farthest = std::max(farthest, glm::length(wanted));
            ++(d.skin != kNone ? skinned : morphed);
        }
    }
    EXPECT_GT(skinned, 50u);
    EXPECT_GT(morphed, 50u);
    EXPECT_GT(farthest, 1.0);
}

// Bilinear; x and y count from the first pixel's centre.
glm::vec3 between(const Image& image, double x, double y) {
    const auto x0 = static_cast<std::uint32_t>(x), y0 = static_cast<std::uint32_t>(y);
    const auto fx = static_cast<float>(x - x0), fy = static_cast<float>(y - y0);
    return (1 - fy) * ((1 - fx) * color(image, x0, y0) + fx * color(image, x0 + 1, y0)) +
           fy * ((1 - fx) * color(image, x0, y0 + 1) + fx * color(image, x0 + 1, y0 + 1));
}

// Means over pixels whose surface is seen in the other frame, too: of the difference of base
// colours when the other frame is warped onto this one, and when it is not.
struct Warped {
    double warped = 0.0, still = 0.0, length = 0.0;
    std::size_t pixels = 0, hidden = 0;
};
Warped warpedOnto(const FrameRequest& r) {
    FrameRequest other = r;
    other.time = r.output.flow->time;
    if (r.output.flow->camera) other.camera = *r.output.flow->camera;
    const Image flow = channel(r, Channel::flow);
    const Image here = channel(r, Channel::albedo), there = channel(other, Channel::albedo);
    const Image depth = channel(other, Channel::depth);
    Warped result;
    for (std::uint32_t y = 0; y < r.height; ++y) {
        for (std::uint32_t x = 0; x < r.width; ++x) {
            const glm::vec3 f = color(flow, x, y);
            const double toX = x + f.x, toY = y + f.y;
            if (f.z == 0.0f || toX < 0 || toY < 0 || toX >= r.width - 1.0 || toY >= r.height - 1.0)
                continue;
            const float found = number(depth, static_cast<std::uint32_t>(std::lround(toX)),
                                       static_cast<std::uint32_t>(std::lround(toY)));
            if (std::abs(found - f.z) > 0.01f * f.z) {
                ++result.hidden;
                continue;
            }
            ++result.pixels;
            result.length += glm::length(glm::vec2(f));
            result.warped += glm::length(between(there, toX, toY) - color(here, x, y));
            result.still += glm::length(color(there, x, y) - color(here, x, y));
        }
    }
    for (double* sum : {&result.warped, &result.still, &result.length}) *sum /= result.pixels;
    return result;
}

TEST_F(Flow, WarpsOneFrameOntoTheNext) {
    FrameRequest r = meadow(0.2);
    r.camera.position = glm::dvec3(2.4, 1.2, 2.6);
    r.camera.target = glm::dvec3(0.0, 0.4, 0.0);
    CameraRequest next = r.camera;
    next.position = glm::dvec3(2.0, 1.2, 2.9);
    for (const bool back : {false, true}) {
        FrameRequest from = r;
        from.output.flow = FlowRequest{.time = 0.3, .camera = next};
        if (back) {
            from.output.flow = FlowRequest{.time = r.time, .camera = r.camera};
            from.time = 0.3;
            from.camera = next;
        }
        const Warped w = warpedOnto(from);
        RecordProperty(back ? "back" : "forward", std::to_string(w.warped / w.still));
        EXPECT_GT(w.pixels, 10'000u);
        EXPECT_LT(w.hidden, w.pixels / 4);
        EXPECT_GT(w.length, 3.0) << "pixels";
        EXPECT_LT(w.warped, 0.25 * w.still) << back;
    }
}

TEST_F(Flow, ErrorsNameTheirField) {
    FrameRequest r = meadow(0.0);
    ASSERT_EQ(errorsOf(r).size(), 1u);
    EXPECT_EQ(errorsOf(r)[0].pointer, "/output/flow");
    CameraRequest camera;
    camera.name = "no such camera";
    r.output.flow = FlowRequest{.time = 1.0, .camera = camera};
    ASSERT_EQ(errorsOf(r).size(), 1u);
    EXPECT_EQ(errorsOf(r)[0].pointer, "/output/flow/camera/name");
    camera.name.reset();
    camera.position = camera.target = glm::dvec3(1.0);
    r.output.flow->camera = camera;
    ASSERT_EQ(errorsOf(r).size(), 1u);
    EXPECT_EQ(errorsOf(r)[0].pointer, "/output/flow/camera/target");
}

}  // namespace
}  // namespace clerestory::test
