// Fitted views: corners touch the frame, whatever the lens and the direction.
#include "scene/fit.h"
#include "plan/planner.h"
#include "plan/visibility/view.h"
#include "plan_scenes.h"
#include "scene/default_view.h"

#include <gmock/gmock.h>

#include <optional>
#include <random>

namespace clerestory::test {
namespace {

// Two boxes at nodes of their own, and a ball.
Scene stillLife() {
    Scene scene;
    const Index red = addMaterial(scene, {.name = "red"}),
                blue = addMaterial(scene, {.name = "blue"});
    place(scene, addBoxMesh(scene, "box", red), {0, 1, 0}, 1.0);
    scene.nodes.back().name = "table";
    place(scene, addBallMesh(scene, "ball", blue), {3, 0.5, -1}, 0.5);
    scene.nodes.back().name = "ball";
    place(scene, addBoxMesh(scene, "small", blue), {-4, 0.25, 2}, 0.25);
    scene.nodes.back().name = "dice";
    updateContentHash(scene);
    return scene;
}

struct Extent {
    glm::dvec2 low{1e9}, high{-1e9};  // normalised: the frame is from -1 to 1
};
Extent extentOf(const Scene& scene, const View& view, const std::vector<bool>& chosen) {
    Extent extent;
    for (const glm::dvec3& corner : cornersOf(scene, poseAt(scene, 0.0), chosen)) {
        const glm::dvec4 eye = view.viewFromWorld * glm::dvec4(corner, 1.0);
        EXPECT_LT(eye.z, 0.0) << "behind the camera";
        const glm::dvec4 clip = view.clipFromView * eye;
        const glm::dvec2 at = glm::dvec2(clip) / clip.w;
        extent.low = glm::min(extent.low, at);
        extent.high = glm::max(extent.high, at);
    }
    return extent;
}

TEST(Fit, CornersTouchTwoOppositeSidesAndStayInTheMiddle) {
    const Scene scene = stillLife();
    std::mt19937 random(4);
    std::uniform_real_distribution<double> angle(-3.2, 3.2), upwards(-1.5707963, 1.5707963),
        margin(0.0, 0.4), yfov(0.1, 1.5);
    for (int i = 0; i < 300; ++i) {
        CameraRequest camera;
        camera.fit = FitRequest{
            .azimuth = angle(random),
            .elevation = i % 10 == 0 ? (i % 20 ? 1.5707964 : -1.5707964) : upwards(random),
            .margin = margin(random)};
        std::vector<bool> chosen(3, true);
        if (i % 3 == 1) camera.fit->node = "ball", chosen = {false, true, false};
        if (i % 3 == 2) camera.fit->material = "blue", chosen = {false, true, true};
        const std::uint32_t width = i % 2 ? 160 : 90, height = i % 2 ? 90 : 160;
        if (i % 4 == 3) {  // the axis is not in the middle of the frame
            camera.intrinsics = Intrinsics{.fx = 120, .fy = 150, .cx = 30.0, .cy = 70.0};
        } else {
            camera.yfov = yfov(random);
        }
        const View view = requestedView(camera, scene, poseAt(scene, 0.0), width, height);
        const Extent extent = extentOf(scene, view, chosen);
        const double inner = 1.0 - 2.0 * camera.fit->margin;
        const glm::dvec2 size = 0.5 * (extent.high - extent.low);
        EXPECT_NEAR(std::max(size.x, size.y), inner, 1e-6) << i;
        const int along = size.x > size.y ? 0 : 1;
        EXPECT_NEAR(extent.high[along], inner, 1e-6) << i;
        EXPECT_NEAR(extent.low[along], -inner, 1e-6) << i;
        EXPECT_LE(extent.high[1 - along], inner + 1e-6) << i;
        EXPECT_GE(extent.low[1 - along], -inner - 1e-6) << i;
    }
}

// A camera that goes round keeps its distance from the axis and its height, sees everything from
// everywhere, and from nowhere nearer would.
TEST(Fit, AllAroundIsOneDistanceForAllAzimuths) {
    const Scene scene = stillLife();
    const std::vector<bool> all(3, true);
    for (const double elevation : {-0.7, 0.0, 0.4, 1.2}) {
        double widest = 0.0;
        std::optional<glm::dvec2> first;
        const Bounds box = lastingBounds(scene, restPose(scene));
        for (int i = 0; i < 360; ++i) {
            CameraRequest camera;
            camera.fit = FitRequest{
                .azimuth = glm::radians(double(i)), .elevation = elevation, .allAround = true};
            const View view = requestedView(camera, scene, poseAt(scene, 0.0), 120, 90);
            const glm::dvec3 eye = view.eye;
            const glm::dvec2 place(std::hypot(eye.x - box.center().x, eye.z - box.center().z),
                                   eye.y);
            if (!first) first = place;
            EXPECT_NEAR(place.x, first->x, 1e-5) << i;
            EXPECT_NEAR(place.y, first->y, 1e-5) << i;
            const Extent extent = extentOf(scene, view, all);
            for (const double edge : {extent.high.x, extent.high.y, -extent.low.x, -extent.low.y}) {
                widest = std::max(widest, edge);
            }
        }
        EXPECT_LE(widest, 0.8);
        EXPECT_GT(widest, 0.78) << elevation;
    }
}

TEST(Fit, DirectionsAreThoseOfTheirAngles) {
    EXPECT_NEAR(glm::distance(directionTo(0.0, 0.0), {0, 0, 1}), 0.0, 1e-12);
    EXPECT_NEAR(glm::distance(directionTo(glm::half_pi<double>(), 0.0), {1, 0, 0}), 0.0, 1e-12);
    EXPECT_NEAR(glm::distance(directionTo(1.0, glm::half_pi<double>()), {0, 1, 0}), 0.0, 1e-12);
    const FitRequest standard;
    EXPECT_NEAR(glm::distance(directionTo(standard.azimuth, standard.elevation),
                              glm::normalize(glm::dvec3(0.5, 0.35, 1.0))),
                0.0, 1e-6)
        << "that of default views";
}

TEST(Fit, UnknownNamesAndSecondPosesAreRejected) {
    const Scene scene = stillLife();
    CameraRequest camera;
    camera.fit = FitRequest{.node = "bal"};
    try {
        requestedView(camera, scene, poseAt(scene, 0.0), 16, 9);
        FAIL() << "it was accepted";
    } catch (const InvalidRequest& error) {
        EXPECT_EQ(error.errors()[0].pointer, "/camera/fit/node");
        EXPECT_THAT(error.errors()[0].detail, testing::HasSubstr("did you mean"));
        EXPECT_THAT(error.errors()[0].allowed, testing::HasSubstr("ball"));
    }
    camera.fit = FitRequest{.node = "table", .material = "blue"};  // nothing has both
    EXPECT_THROW(requestedView(camera, scene, poseAt(scene, 0.0), 16, 9), InvalidRequest);
    FrameRequest request;
    request.camera.fit = FitRequest{};
    request.camera.position = glm::dvec3(0.0);
    request.camera.target = glm::dvec3(1.0);
    ASSERT_EQ(problems(request).size(), 1u);
    EXPECT_EQ(problems(request)[0].pointer, "/camera/fit");
}

// A picture as high as a box shows it from edge to edge.
TEST(Lens, AnOrthographicHeightIsThatOfThePicture) {
    Scene scene = boxScene();
    CameraRequest camera;
    camera.position = glm::dvec3(0, 0, 9);
    camera.target = glm::dvec3(0.0);
    camera.orthographicHeight = 4.0;
    const View view = requestedView(camera, scene, poseAt(scene, 0.0), 30, 20);
    EXPECT_TRUE(view.orthographic);
    const auto at = [&](const glm::dvec3& p) {
        const glm::dvec4 clip = view.clipFromView * view.viewFromWorld * glm::dvec4(p, 1.0);
        return glm::dvec2(clip) / clip.w;
    };
    for (const double z : {-3.0, 0.0, 5.0}) {
        EXPECT_NEAR(glm::distance(at({3, 2, z}), {1, 1}), 0.0, 1e-9);
        EXPECT_NEAR(glm::distance(at({0, -1, z}), {0, -0.5}), 0.0, 1e-9);
    }
    FrameRequest both;
    both.camera = camera;
    both.camera.yfov = 0.5;
    ASSERT_EQ(problems(both).size(), 1u);
    EXPECT_EQ(problems(both)[0].pointer, "/camera/orthographicHeight");
}

}  // namespace
}  // namespace clerestory::test
