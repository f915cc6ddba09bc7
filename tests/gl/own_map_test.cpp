// Reflections that a material selects by name: a stored map with its own rotation, and probes
// placed in the scene.
#include "support.h"

#include "scene/builtin/builtin_scenes.h"

#include <glm/gtc/matrix_transform.hpp>

namespace clerestory::test {
namespace {

class MaterialMaps : public GlTest {};

// Six faces, each of one colour, OpenGL's order.
constexpr std::array<glm::vec3, 6> kColors = {
    {{1, 0, 0}, {0, 1, 1}, {0, 1, 0}, {1, 0, 1}, {0, 0, 1}, {1, 1, 0}}};

void addColoredMap() {
    auto map = std::make_shared<EnvironmentMap>();
    map->name = "six colours";
    map->faceSize = 8;
    for (const glm::vec3& color : kColors) map->texels.insert(map->texels.end(), 64, color);
    completeMap(*map);
    renderer().addEnvironment(map);
}

Material mirrorWithMap(const glm::dquat& rotation) {
    return {.name = "mirror",
            .metallic = 1.0f,
            .roughness = 0.0f,
            .environmentMap = "six colours",
            .environmentRotation = rotation};
}

// A mirror ball straight ahead: its middle mirrors what lies behind the eye.
glm::vec3 behindTheEye(const glm::dquat& rotation, const glm::dvec3& eye) {
    Scene scene;
    place(scene, sphere(0.5f, 48, addMaterial(scene, mirrorWithMap(rotation))));
    FrameRequest r = request(std::move(scene), "own map", eye);
    r.camera.target = glm::dvec3(0.0);
    return centerColor(renderer().render(r).image);
}

TEST_F(MaterialMaps, FollowTheRotation) {
    addColoredMap();
    const glm::dquat none(1, 0, 0, 0);
    EXPECT_LT(glm::distance(behindTheEye(none, {0, 0, 3}), kColors[4]), 0.01f);
    EXPECT_LT(glm::distance(behindTheEye(none, {3, 0, 0}), kColors[0]), 0.01f);
    EXPECT_LT(glm::distance(behindTheEye(none, {0, -3, 1e-3}), kColors[3]), 0.01f);
    // The map turned a quarter about +Y: what stood at +X stands at -Z, what stood at +Z at +X.
    const glm::dquat quarter = glm::angleAxis(glm::half_pi<double>(), glm::dvec3(0, 1, 0));
    EXPECT_LT(glm::distance(behindTheEye(quarter, {0, 0, -3}), kColors[0]), 0.01f);
    EXPECT_LT(glm::distance(behindTheEye(quarter, {3, 0, 0}), kColors[4]), 0.01f);
}

TEST_F(MaterialMaps, NeedNoCapture) {
    addColoredMap();
    Scene scene;
    place(scene, sphere(0.5f, 24, addMaterial(scene, mirrorWithMap({1, 0, 0, 0}))));
    const Frame frame = renderer().render(request(std::move(scene), "own map"));
    for (const Pass& pass : frame.plan.passes) EXPECT_NE(pass.kind(), "capture");
}

// In a room whose six walls glow, the cube caught in the middle and the one caught near the +X wall
// differ, and the ball shows the one that its material names.
TEST_F(MaterialMaps, PlacedProbesAreSelectedByName) {
    const auto wallSeen = [](const std::string& probe) {
        Scene scene = sixWalls();
        scene.probes.push_back({.name = "middle", .position = {0, 0, 0}, .size = 0.1});
        scene.probes.push_back(
            {.name = "corner", .position = {1.9, 0, 0}, .size = 0.1, .resolution = 64});
        for (Material& m : scene.materials) {
            if (m.name == "mirror") m.probe = probe;
        }
        FrameRequest r = request(std::move(scene), "placed", {0, 0, 1.5});
        r.accuracy.parallax = Parallax::none;
        r.width = r.height = 129;
        const Frame frame = renderer().render(r);
        EXPECT_EQ(frame.plan.decisions.size(), 1u);
        // Mirrored some 51 degrees to the left of straight back: from the middle that way ends at
        // the -X wall, from near the +X wall at the +Z wall.
        return color(frame.image, 53, 64);
    };
    const glm::vec3 middle = wallSeen("middle"), corner = wallSeen("corner");
    EXPECT_GT(glm::distance(middle, corner), 0.05f);
    EXPECT_GT(glm::length(middle), 0.05f);
    EXPECT_GT(glm::length(corner), 0.05f);
}

}  // namespace
}  // namespace clerestory::test
