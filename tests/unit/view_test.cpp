// Cameras: one pose in every form, projection by intrinsics, frusta that never exclude visible
// objects.
#include "plan/visibility/view.h"
#include "plan/visibility/visibility.h"

#include "plan_scenes.h"

#include <glm/gtc/matrix_transform.hpp>

#include <gtest/gtest.h>
#include <random>

namespace clerestory::test {
namespace {

constexpr std::uint32_t kWidth = 640, kHeight = 480;

View viewOf(const CameraRequest& camera, const Scene& scene = boxScene()) {
    return requestedView(camera, scene, poseAt(scene, 0), kWidth, kHeight);
}

glm::dvec3 ndc(const View& view, const glm::dvec3& world) {
    const glm::dvec4 clip = view.clipFromView * view.viewFromWorld * glm::dvec4(world, 1.0);
    return glm::dvec3(clip) / clip.w;
}

// The projection of a world point, pixels from the left and top edges of the image.
glm::dvec2 pixel(const View& view, const glm::dvec3& world) {
    const glm::dvec3 n = ndc(view, world);
    return {(0.5 + 0.5 * n.x) * kWidth, (0.5 - 0.5 * n.y) * kHeight};
}

CameraRequest lookAt(const glm::dvec3& position, const glm::dvec3& target,
                     const glm::dvec3& up = glm::dvec3(0, 1, 0)) {
    CameraRequest c;
    c.position = position;
    c.target = target;
    c.up = up;
    return c;
}

TEST(View, LookAtQuaternionAndMatrixOfOnePoseGiveTheSameBits) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> any(-10, 10);
    for (int i = 0; i < 1000; ++i) {
        const glm::dvec3 position(any(random), any(random), any(random));
        const CameraRequest looked = lookAt(position, {any(random), any(random), any(random)});
        const glm::dmat4 m = worldFromLookAt(position, *looked.target, *looked.up);
        const glm::dquat q = glm::quat_cast(glm::dmat3(m));
        CameraRequest turned;
        turned.position = position;
        turned.orientation = {-q.x, -q.y, -q.z, -q.w};  // the same rotation
        CameraRequest matrix;
        matrix.cameraToWorld.emplace();
        for (int k = 0; k < 16; ++k) (*matrix.cameraToWorld)[k] = m[k / 4][k % 4];
        CameraRequest cv = matrix;
        cv.convention = Convention::opencv;
        for (int k = 4; k < 12; ++k) (*cv.cameraToWorld)[k] *= -1.0;
        EXPECT_EQ(viewOf(looked), viewOf(turned));
        EXPECT_EQ(viewOf(looked), viewOf(matrix));
        EXPECT_EQ(viewOf(looked), viewOf(cv));
    }
}

TEST(View, TheTargetIsCentredAndUpIsUp) {
    const View view = viewOf(lookAt({3, 4, 5}, {0, 1, 0}));
    EXPECT_NEAR(ndc(view, {0, 1, 0}).x, 0.0, 1e-8);
    EXPECT_NEAR(ndc(view, {0, 1, 0}).y, 0.0, 1e-8);
    EXPECT_GT(ndc(view, {0, 1.5, 0}).y, 0.0);
}

TEST(View, UpAlongTheLineOfSightIsReplaced) {
    for (const glm::dvec3& target : {glm::dvec3(0, -5, 0), glm::dvec3(0, 5, 0)}) {
        const View view = viewOf(lookAt({0, 0, 0}, target));
        EXPECT_GT(ndc(view, target + glm::dvec3(0, 0, -1)).y, 0.0) << "-Z is up in the picture";
        EXPECT_NEAR(glm::determinant(glm::dmat3(view.viewFromWorld)), 1.0, 1e-12);
    }
    const View alongZ = viewOf(lookAt({0, 0, 0}, {0, 0, -5}, {0, 0, -1}));
    EXPECT_GT(ndc(alongZ, {0, 1, -5}).y, 0.0);
}

TEST(View, TheFieldOfViewEndsAtTheImageEdge) {
    CameraRequest camera = lookAt({0, 0, 0}, {0, 0, -1});
    for (const double degrees : {1.0, 60.0, 120.0, 179.0}) {
        camera.yfov = glm::radians(degrees);
        const double edge = std::tan(0.5 * *camera.yfov);
        EXPECT_NEAR(pixel(viewOf(camera), {0, edge * 7, -7}).y, 0.0, 1e-6);
        EXPECT_NEAR(pixel(viewOf(camera), {edge * 7 * kWidth / kHeight, 0, -7}).x, kWidth, 1e-6);
    }
}

TEST(View, IntrinsicsPutAPointOnTheStatedPixel) {
    CameraRequest camera = lookAt({0, 0, 0}, {0, 0, -1});
    camera.intrinsics = Intrinsics{500, 510, 300, 250, PixelCenter::half};
    const glm::dvec2 half = pixel(viewOf(camera), {0.2, -0.1, -2});
    EXPECT_NEAR(half.x, 500 * 0.1 + 300, 1e-6);
    EXPECT_NEAR(half.y, 510 * 0.05 + 250, 1e-6);
    camera.intrinsics->pixelCenter = PixelCenter::integer;
    EXPECT_NEAR(pixel(viewOf(camera), {0.2, -0.1, -2}).x, half.x + 0.5, 1e-6);
}

TEST(View, DepthIsOneAtTheNearPlaneAndFallsToZero) {
    CameraRequest camera = lookAt({0, 0, 0}, {0, 0, -1});
    camera.znear = 0.5;
    EXPECT_NEAR(ndc(viewOf(camera), {0, 0, -0.5}).z, 1.0, 1e-9);
    EXPECT_NEAR(ndc(viewOf(camera), {0, 0, -5e8}).z, 1e-9, 1e-12);
    camera.zfar = 100.0;
    EXPECT_NEAR(ndc(viewOf(camera), {0, 0, -0.5}).z, 1.0, 1e-9);
    EXPECT_NEAR(ndc(viewOf(camera), {0, 0, -100}).z, 0.0, 1e-9);
}

TEST(View, SceneCamerasKeepPositionAndDropScale) {
    Scene scene = boxScene();
    const Index node = addNode(
        scene, "camera", glm::scale(glm::translate(glm::dmat4(1.0), {0, 0, 8}), glm::dvec3(3)));
    scene.cameras.push_back({.name = "c", .node = node, .yfov = 0.5, .znear = 0.25});
    CameraRequest camera;
    camera.name = "c";
    const View view = viewOf(camera, scene);
    EXPECT_EQ(view.eye, glm::dvec3(0, 0, 8));
    EXPECT_EQ(view.znear, 0.25);
    EXPECT_NEAR(pixel(view, {0, std::tan(0.25) * 8, 0}).y, 0.0, 1e-6);
}

TEST(View, AnOrthographicCameraKeepsParallelLinesParallel) {
    Scene scene = boxScene();
    scene.cameras.push_back(
        {.name = "o",
         .node = addNode(scene, "n", glm::translate(glm::dmat4(1.0), {0, 0, 8})),
         .orthographic = true,
         .yHalfHeight = 2.0});
    CameraRequest camera;
    camera.name = "o";
    const View view = viewOf(camera, scene);
    EXPECT_TRUE(view.orthographic);
    EXPECT_EQ(pixel(view, {1, 1, 0}), pixel(view, {1, 1, -1}));
    EXPECT_NEAR(pixel(view, {0, 2, 0}).y, 0.0, 1e-9);
    EXPECT_GT(ndc(view, {0, 0, 1}).z, ndc(view, {0, 0, -1}).z);
}

// Two ways to one answer: a point that projects into the picture lies in no culled box.
TEST(Visibility, NoBoxWithAVisiblePointIsOutside) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> any(-20, 20);
    int visible = 0;
    for (int i = 0; i < 20000; ++i) {
        CameraRequest camera = lookAt({any(random), any(random), any(random)},
                                      {any(random), any(random), any(random)});
        camera.yfov = 0.3 + 2.5 * (i % 7) / 7.0;
        const View view = viewOf(camera);
        const glm::dvec3 point(any(random), any(random), any(random));
        const glm::dvec3 n = ndc(view, point);
        const double w = (view.clipFromView * view.viewFromWorld * glm::dvec4(point, 1.0)).w;
        if (w < view.znear || std::abs(n.x) > 1 || std::abs(n.y) > 1) continue;
        ++visible;
        Bounds box;
        box.add(glm::vec3(point - view.eye));
        box.add(box.min +
                glm::vec3(std::abs(any(random)), std::abs(any(random)), std::abs(any(random))));
        EXPECT_FALSE(outside(frustumOf(view), box));
    }
    EXPECT_GT(visible, 1000);
}

TEST(Visibility, BoxesBehindAndToTheSideAreOutside) {
    const Frustum frustum = frustumOf(viewOf(lookAt({0, 0, 0}, {0, 0, -1})));
    const auto box = [](const glm::vec3& center) {
        Bounds b;
        b.add(center - 1.0f);
        b.add(center + 1.0f);
        return b;
    };
    EXPECT_FALSE(outside(frustum, box({0, 0, -5})));
    for (const glm::vec3& c : {glm::vec3(0, 0, 5), glm::vec3(20, 0, -5), glm::vec3(0, -20, -5)}) {
        EXPECT_TRUE(outside(frustum, box(c)));
    }
    EXPECT_TRUE(outside(frustum, Bounds{}));
}

TEST(Visibility, ScreenShareOfABoxThatFillsAQuarter) {
    CameraRequest camera = lookAt({0, 0, 0}, {0, 0, -1});
    camera.yfov = 2.0 * std::atan(1.0);  // the picture is 2 high at distance 1
    const double aspect = static_cast<double>(kWidth) / kHeight;
    Bounds flat;
    flat.add({-0.5 * aspect, -0.5, -1.0});
    flat.add({0.5 * aspect, 0.5, -1.0});
    EXPECT_NEAR(screenBox(viewOf(camera), flat).share(), 0.25, 1e-6);
    Bounds around;
    around.add(glm::vec3(-1.0f));
    around.add(glm::vec3(1.0f));
    EXPECT_EQ(screenBox(viewOf(camera), around).share(), 1.0);
}

}  // namespace
}  // namespace clerestory::test
