// Pixels and points under every lens, and points that stay on their surface.
#include "plan/graph/projection.h"
#include "plan/visibility/view.h"
#include "plan_scenes.h"
#include "scene/surface_point.h"

#include <gtest/gtest.h>

#include <random>

namespace clerestory::test {
namespace {

Projection projectionOf(const std::optional<LensRequest>& lens) {
    const Scene scene;
    const Pose pose;
    CameraRequest camera;
    camera.position = glm::dvec3(1000.0, -20.0, 3.0);
    camera.target = glm::dvec3(990.0, -19.0, 10.0);
    camera.lens = lens;
    return {requestedView(camera, scene, pose, 320, 200),
            requestedLens(camera, scene, pose, 320, 200), 320, 200};
}

TEST(Projection, LeadsFromAPixelToItsPointsAndBack) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (const std::optional<LensRequest>& lens :
         {std::optional<LensRequest>(), std::optional<LensRequest>(PerspectiveLens{.k1 = -0.1}),
          std::optional<LensRequest>(OrthographicLens{3.0}),
          std::optional<LensRequest>(EquirectangularLens{}),
          std::optional<LensRequest>(FisheyeLens{.k1 = 0.02}),
          std::optional<LensRequest>(CubeLens{})}) {
        const Projection p = projectionOf(lens);
        std::size_t tried = 0;
        for (int i = 0; i < 500; ++i) {
            const glm::dvec2 pixel(320.0 * unit(random), 200.0 * unit(random));
            const auto ray = rayThrough(p, pixel);
            if (!ray) continue;
            ++tried;
            const double along = 0.1 + 100.0 * unit(random);
            const auto back = projected(p, ray->origin + along * ray->direction);
            ASSERT_TRUE(back.has_value());
            EXPECT_LT(glm::length(back->pixel - pixel), 1e-7);
            EXPECT_GT(back->depth, 0.0);
        }
        EXPECT_GT(tried, 100u);
    }
}

TEST(Projection, HidesWhatIsBehindTheCamera) {
    const Projection p = projectionOf({});
    const PixelRay ray = *rayThrough(p, {160.0, 100.0});
    EXPECT_FALSE(projected(p, ray.origin - ray.direction).has_value());
    EXPECT_FALSE(projected(p, ray.origin).has_value());
}

TEST(Projection, PanoramasAreCrossedTheShorterWay) {
    const Projection whole = projectionOf(EquirectangularLens{});
    EXPECT_EQ(displacement(whole, {310.0, 50.0}, {10.0, 60.0}), glm::dvec2(20.0, 10.0));
    const Projection half = projectionOf(EquirectangularLens{.longitude = 3.0});
    EXPECT_EQ(displacement(half, {310.0, 50.0}, {10.0, 60.0}), glm::dvec2(-300.0, 10.0));
}

TEST(SurfacePoints, AreWhereTheRayMeetsTheTriangle) {
    Scene scene;
    scene.materials.emplace_back();
    scene.nodes.push_back({"box", kNone, glm::dmat4(2.0)});
    scene.nodes[0].parentFromLocal[3] = {5.0, 0.0, 0.0, 1.0};
    addInstance(scene, 0, addBoxMesh(scene, "box", 0));
    const Pose pose = restPose(scene);
    const glm::dvec3 origin(5.1, 0.2, 40.0), ahead(0.0, 0.0, -2.0);
    std::size_t met = 0;
    for (std::uint32_t first = 0; first < scene.indices.size(); first += 3) {
        const SurfacePoint point = pointAlong(scene, pose, 0, first, origin, ahead);
        EXPECT_NEAR(point.weights.x + point.weights.y + point.weights.z, 1.0, 1e-12);
        const glm::dvec3 at = positionOf(scene, pose, point);
        met += glm::length(glm::dvec2(at) - glm::dvec2(origin)) < 1e-9;
        EXPECT_TRUE(finite(at)) << "also of triangles that are seen edge-on";
    }
    EXPECT_EQ(met, 2u) << "front and back";
}

}  // namespace
}  // namespace clerestory::test
