// The ground plane that a request adds to a scene.
#include "plan_scenes.h"

#include "scene/bvh.h"
#include "scene/classification.h"
#include "scene/compose.h"
#include "scene/fit.h"
#include "scene/ground.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace clerestory::test {
namespace {

using testing::IsEmpty;

// A box of edge 2, turned by 45 degrees about Z: its lowest edge is at -sqrt(2).
Scene tilted() {
    Scene scene;
    scene.materials = {{.name = "steel"}};
    const glm::dmat4 turned =
        glm::rotate(glm::dmat4(1.0), 0.25 * glm::pi<double>(), glm::dvec3(0, 0, 1));
    addInstance(scene, addNode(scene, "box", turned), addBoxMesh(scene, "box", 0));
    updateContentHash(scene);
    return scene;
}

double heightOf(const Scene& scene) {
    return restPose(scene).worldFromNode[scene.instances[scene.ground].node][3].y;
}

TEST(Ground, LiesAtTheLowestPoint) {
    Scene scene = tilted();
    const Bounds before = lastingBounds(scene, restPose(scene));
    addGround(scene, {}, false);
    EXPECT_THAT(sceneProblems(scene), IsEmpty());
    ASSERT_NE(scene.ground, kNone);
    const double gap = -std::sqrt(2.0) - heightOf(scene);
    EXPECT_GT(gap, 0.0);
    EXPECT_LT(gap, 1e-4 * before.diagonal());
    EXPECT_EQ(lastingBounds(scene, restPose(scene)).max, before.max);
    EXPECT_EQ(lastingBounds(scene, restPose(scene)).min, before.min);
    const Bounds all = worldBounds(scene, restPose(scene));
    EXPECT_NEAR(all.max.x - all.min.x, 12.0 * before.diagonal(), 1e-3 * before.diagonal());

    Scene given = tilted();
    addGround(given, {.height = -5.0, .size = 4.0}, false);
    EXPECT_EQ(heightOf(given), -5.0);
    EXPECT_FLOAT_EQ(worldBounds(given, restPose(given)).max.x, 2.0f);
}

TEST(Ground, FacesUpInOnePlane) {
    Scene scene = tilted();
    addGround(scene, {.roughness = 0.0, .reflectance = 0.09}, false);
    const Mesh& mesh = scene.meshes[scene.instances[scene.ground].mesh];
    ASSERT_EQ(mesh.flatPartCount, 1u);
    EXPECT_NEAR(scene.flatParts[mesh.firstFlatPart].normal.y, 1.0, 1e-9);
    EXPECT_EQ(scene.flatParts[mesh.firstFlatPart].clusterCount, mesh.clusterCount);
    EXPECT_NEAR(scene.materials.back().ior, 1.3 / 0.7, 1e-6);
    bool mirror = false;
    for (const Surface& s : surfacesOf(scene)) {
        if (s.instance != scene.ground) continue;
        mirror = s.reflector == Reflector::flat;
        EXPECT_NEAR(s.reflectance, 0.09, 1e-6);
    }
    EXPECT_TRUE(mirror);
}

TEST(Ground, RaysPassACatcher) {
    Scene surface = tilted(), catcher = tilted();
    addGround(surface, {}, false);
    addGround(catcher, {}, true);
    EXPECT_EQ(stillTriangles(catcher, restPose(catcher)).triangles.size(), 12u);
    EXPECT_GT(stillTriangles(surface, restPose(surface)).triangles.size(), 5000u);
}

TEST(Ground, IsNoPartOfAFit) {
    Scene scene = tilted();
    const auto all = cornersOf(scene, restPose(scene), {}, 1000);
    addGround(scene, {}, false);
    EXPECT_EQ(cornersOf(scene, restPose(scene), {}, 1'000'000).size(), all.size());
}

TEST(Ground, AnEmptySceneHasOneAtAGivenHeightOnly) {
    Scene empty;
    addGround(empty, {}, true);
    EXPECT_EQ(empty.ground, kNone);
    addGround(empty, {.height = 1.0}, true);
    ASSERT_NE(empty.ground, kNone);
    EXPECT_EQ(heightOf(empty), 1.0);
    EXPECT_TRUE(std::isfinite(worldBounds(empty, restPose(empty)).diagonal()));
}

TEST(Ground, CompositionsHashItsFields) {
    const Scene scene = tilted();
    const auto hash = [&](const GroundPlane& ground, bool catcher) {
        return composed(scene, {{}, std::nullopt, ground, catcher}).contentHash;
    };
    EXPECT_EQ(hash({}, true), hash({.shadowCatcher = true}, true)) << "as it is resolved";
    EXPECT_NE(hash({}, true), hash({}, false));
    EXPECT_NE(hash({}, true), scene.contentHash);
    EXPECT_NE(hash({.roughness = 0.5}, false), hash({}, false));
    EXPECT_NE(hash({.height = 0.0}, false), hash({}, false));
}

}  // namespace
}  // namespace clerestory::test
