// Camera paths: through every key, linear or smooth, along the shorter rotation.
#include "plan/visibility/camera_path.h"
#include "plan/visibility/view.h"

#include <gtest/gtest.h>

namespace clerestory::test {
namespace {

CameraKey key(double time, const glm::dvec3& position, const glm::dvec3& target) {
    CameraKey k{.time = time};
    k.camera.position = position;
    k.camera.target = target;
    return k;
}

CameraKey turned(double time, double angle) {  // about +Y
    CameraKey k{.time = time};
    k.camera.position = glm::dvec3(0.0);
    k.camera.orientation = {0.0, std::sin(0.5 * angle), 0.0, std::cos(0.5 * angle)};
    return k;
}

glm::dvec3 forward(const CameraRequest& camera) {
    return -glm::dvec3((*worldFromPose(camera))[2]);
}

TEST(CameraPath, HasFramesAtEveryMultipleOfTheRate) {
    CameraPath path{.keys = {key(1.0, {0, 0, 0}, {0, 0, -1}), key(1.3, {3, 0, 0}, {0, 0, -1})},
                    .frameRate = 10.0};
    const auto frames = framesOf(path);
    ASSERT_EQ(frames.size(), 4u) << "0.3 s at 10 a second, though 0.3 * 10 < 3 in doubles";
    EXPECT_DOUBLE_EQ(frames[0].time, 1.0);
    EXPECT_DOUBLE_EQ(frames[3].time, 1.3);
    EXPECT_EQ(frameCount({.keys = {path.keys[0]}}), 1.0);
}

TEST(CameraPath, BothInterpolationsPassThroughEveryKey) {
    for (const PathInterpolation way : {PathInterpolation::linear, PathInterpolation::smooth}) {
        const CameraPath path{.keys = {key(0, {0, 1, 5}, {0, 0, 0}), key(1, {4, 2, 3}, {1, 0, 0}),
                                       key(3, {5, 1, -4}, {0, 2, 0})},
                              .frameRate = 2.0,
                              .interpolation = way};
        const auto frames = framesOf(path);
        for (const auto& [frame, of] : {std::pair{0, 0}, std::pair{2, 1}, std::pair{6, 2}}) {
            const CameraRequest& there = frames[frame].camera;
            EXPECT_LT(glm::distance(*there.position, *path.keys[of].camera.position), 1e-12);
            EXPECT_LT(glm::distance(*there.target, *path.keys[of].camera.target), 1e-12);
        }
    }
}

TEST(CameraPath, LinearIsStraightAndSmoothHasContinuousSpeed) {
    CameraPath path{.keys = {key(0, {0, 0, 0}, {0, 0, -9}), key(1, {1, 0, 0}, {0, 0, -9}),
                             key(3, {3, 4, 0}, {0, 0, -9})},
                    .frameRate = 1000.0,
                    .interpolation = PathInterpolation::linear};
    EXPECT_LT(glm::distance(*framesOf(path)[500].camera.position, glm::dvec3(0.5, 0, 0)), 1e-12);
    const auto turnAtKey = [&] {
        const auto f = framesOf(path);
        const glm::dvec3 before = *f[1000].camera.position - *f[999].camera.position;
        const glm::dvec3 after = *f[1001].camera.position - *f[1000].camera.position;
        return glm::length(after - before) / glm::length(before);
    };
    EXPECT_GT(turnAtKey(), 0.5);
    path.interpolation = PathInterpolation::smooth;
    EXPECT_LT(turnAtKey(), 0.02);
}

TEST(CameraPath, EvenlySpacedKeysMoveAtConstantSpeed) {
    const CameraPath path{.keys = {key(0, {0, 0, 0}, {0, 0, -1}), key(1, {1, 0, 0}, {1, 0, -1}),
                                   key(2, {2, 0, 0}, {2, 0, -1})},
                          .frameRate = 16.0};
    for (const PathFrame& frame : framesOf(path)) {
        EXPECT_NEAR(frame.camera.position->x, frame.time, 1e-12);
    }
}

TEST(CameraPath, RotatesAlongTheShorterArc) {
    for (const PathInterpolation way : {PathInterpolation::linear, PathInterpolation::smooth}) {
        CameraPath path{
            .keys = {turned(0, -0.5), turned(1, 0.5)}, .frameRate = 2.0, .interpolation = way};
        for (double& c : *path.keys[1].camera.orientation) c = -c;
        const glm::dvec3 middle = forward(framesOf(path)[1].camera);
        EXPECT_LT(glm::distance(middle, glm::dvec3(0, 0, -1)), 1e-12);
    }
}

TEST(CameraPath, OppositeRotationsStayNormalised) {
    CameraPath path{.keys = {turned(0, 0.0), turned(1, 3.14159265358979)}, .frameRate = 64.0};
    for (const PathFrame& frame : framesOf(path)) {
        FrameRequest request;
        request.camera = frame.camera;
        EXPECT_TRUE(problems(request).empty());
    }
}

TEST(CameraPath, TheFieldOfViewIsInterpolated) {
    CameraPath path{.keys = {key(0, {0, 0, 1}, {0, 0, 0}), key(1, {0, 0, 1}, {0, 0, 0})},
                    .frameRate = 2.0};
    path.keys[0].camera.yfov = 0.5;
    path.keys[1].camera.yfov = 1.0;
    EXPECT_NEAR(*framesOf(path)[1].camera.yfov, 0.75, 1e-12);
    path.keys[0].camera.yfov.reset();
    path.keys[0].camera.intrinsics = Intrinsics{.fx = 500, .fy = 500, .cx = 320, .cy = 240};
    const auto lens = framesOf(path)[1].camera.intrinsics;
    ASSERT_TRUE(lens);
    EXPECT_EQ(lens->fx, 500);
}

TEST(CameraPath, OtherLensesAreKept) {
    CameraPath path{.keys = {key(0, {0, 0, 5}, {0, 0, 0}), key(1, {1, 0, 5}, {0, 0, 0})},
                    .frameRate = 2.0};
    path.keys[0].camera.lens = FisheyeLens{.fov = 3.0};
    CameraRequest camera = framesOf(path)[1].camera;
    EXPECT_EQ(camera.lens, LensRequest(FisheyeLens{.fov = 3.0}));
    EXPECT_FALSE(camera.yfov.has_value());
    path.keys[0].camera.lens = PerspectiveLens{.k1 = -0.1};
    EXPECT_TRUE(framesOf(path)[1].camera.yfov.has_value());
    path.keys[0].camera.lens.reset();
    path.keys[0].camera.orthographicHeight = 2.0;
    camera = framesOf(path)[1].camera;
    EXPECT_EQ(camera.orthographicHeight, 2.0);
    EXPECT_FALSE(camera.yfov.has_value());
}

TEST(CameraPath, NamesEveryInvalidKey) {
    CameraPath path{.keys = {key(1, {0, 0, 1}, {0, 0, 0}), key(1, {0, 0, 1}, {0, 0, 0}), {}}};
    path.keys[2].time = 2.0;
    const auto errors = problems(path);
    ASSERT_EQ(errors.size(), 2u);
    EXPECT_EQ(errors[0].pointer, "/keys/1/time");
    EXPECT_EQ(errors[1].pointer, "/keys/2/camera");
    EXPECT_EQ(problems(CameraPath{}).at(0).pointer, "/keys");
}

TEST(View, LensOfIsTheInverseOfPerspective) {
    const Intrinsics lens{.fx = 700, .fy = 650, .cx = 300.5, .cy = 260};
    const Intrinsics back = lensOf(perspective(lens, 640, 480, 0.1, {}), 640, 480);
    EXPECT_NEAR(back.fx, lens.fx, 1e-9);
    EXPECT_NEAR(back.fy, lens.fy, 1e-9);
    EXPECT_NEAR(back.cx, lens.cx, 1e-9);
    EXPECT_NEAR(back.cy, lens.cy, 1e-9);
}

}  // namespace
}  // namespace clerestory::test
