// Clips that change materials, lights and visibility: a moment equals the static scene with those
// values, for every technique and in the reference, whatever was drawn before.
#include "reference/reference.h"
#include "scene/environment.h"
#include "support.h"

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace clerestory::test {
namespace {

class AnimatedFactors : public GlTest {};

constexpr const char* kMoving = "factors moving";
constexpr const char* kStill = "factors still";

// A mirror below, a mirror ball, a lamp, and two balls of one material that are not yet painted.
struct Room {
    Scene scene;
    Index paint = 0, ball = 0;
};
Room room() {
    Room made;
    Scene& scene = made.scene;
    place(scene, quad(4.0f, addMaterial(scene, mirrorMetal(0.9f))),
          glm::rotate(moved(0, -1, 0), -glm::half_pi<double>(), glm::dvec3(1, 0, 0)));
    place(scene, sphere(0.5f, 12, addMaterial(scene, mirrorMetal(0.9f))), moved(0, 0, -1));
    Material paint{.name = "paint", .metallic = 0.0f, .roughness = 0.6f};
    paint.baseColor = {0.8f, 0.1f, 0.1f, 1.0f};
    made.paint = addMaterial(scene, paint);
    place(scene, sphere(0.4f, 12, made.paint), moved(-1.2, 0, -0.5));
    made.ball = static_cast<Index>(scene.instances.size());
    place(scene, sphere(0.4f, 12, made.paint), moved(1.2, 0, -0.5));
    addLight(scene, {.intensity = glm::vec3(8.0f)}, moved(0.5, 2.0, 1.0));
    return made;
}

Track track(AnimatedProperty property, Index target, std::vector<float> values,
            std::string field = {}) {
    return {property,          target,          Interpolation::linear, {0.0f, 2.0f},
            std::move(values), std::move(field)};
}

Scene withClip(Scene scene, std::vector<Track> tracks) {
    scene.clips.push_back({"go", 2.0, std::move(tracks)});
    finishMotion(scene);
    return scene;
}

enum class How { maps, rays, shadows };

// At one second, after another moment was drawn, against the scene in which nothing changes.
void expectSame(const Scene& moving, const Scene& still, const char* what) {
    FrameRequest r = request(moving, kMoving, {0, 0.6, 2.5});
    request(still, kStill);
    for (const How how : {How::maps, How::rays, How::shadows}) {
        r.accuracy = {};
        r.accuracy.planar = how == How::rays ? PlanarMethod::traced : PlanarMethod::mirror;
        r.accuracy.curved = how == How::rays ? CurvedMethod::traced : CurvedMethod::probe;
        r.effects.shadows = how == How::shadows;
        const auto at = [&](const char* scene, double time) {
            r.scene = scene;
            r.time = time;
            return renderer().render(r).image;
        };
        const Image before = at(kMoving, 0.0);
        const Image then = at(kMoving, 1.0);
        EXPECT_GT(differing(before, then), 40u) << what;
        // The trees of the two may be built differently: an edge falls to either side.
        const std::size_t edges = how == How::rays ? 6 : 0;
        EXPECT_LE(differing(then, at(kStill, 0.0)), edges) << what << " " << int(how);
        EXPECT_EQ(differing(before, at(kMoving, 0.0)), 0u) << what;
    }
    renderer().removeScene(kMoving);
    renderer().removeScene(kStill);
}

TEST_F(AnimatedFactors, MaterialsOfAMomentAreThoseOfAStaticScene) {
    const Room made = room();
    const Scene moving = withClip(
        made.scene, {track(AnimatedProperty::material, made.paint,
                           {0.8f, 0.1f, 0.1f, 1, 0, 0.5f, 0.9f, 1}, "baseColor"),
                     track(AnimatedProperty::material, made.paint, {0, 0, 0, 2, 0, 0}, "emissive"),
                     track(AnimatedProperty::material, made.paint, {0, 2}, "metallic"),
                     track(AnimatedProperty::material, made.paint, {0.6f, 0.0f}, "roughness")});
    Scene still = made.scene;
    Material& m = still.materials[made.paint];
    m.baseColor = (glm::vec4(0.8f, 0.1f, 0.1f, 1) + glm::vec4(0, 0.5f, 0.9f, 1)) * 0.5f;
    m.emissive = {1, 0, 0};
    m.metallic = 1.0f;
    m.roughness = 0.3f;
    expectSame(moving, still, "a dull paint that becomes a glowing mirror");
}

// The tree of rays depends on what is glass.
TEST_F(AnimatedFactors, PaintBecomesGlass) {
    const Room made = room();
    const Scene glass = withClip(
        made.scene, {track(AnimatedProperty::material, made.paint, {0, 1}, "transmission")});
    Scene still = made.scene;
    still.materials[made.paint].transmission = 0.5f;
    expectSame(glass, still, "half of it transmits");
}

TEST_F(AnimatedFactors, LightsOfAMomentAreThoseOfAStaticScene) {
    const Room made = room();
    Scene moving = made.scene;
    moving.animatedLights = {{0, {.intensity = 8.0f}}};
    moving = withClip(moving, {track(AnimatedProperty::light, 0, {8, 24}, "intensity"),
                               track(AnimatedProperty::light, 0, {1, 1, 1, 1, 0, 0}, "color")});
    Scene still = made.scene;
    still.lights[0].intensity = {16.0f, 8.0f, 8.0f};
    expectSame(moving, still, "a lamp that turns red");
}

TEST_F(AnimatedFactors, WhatIsHiddenIsNowhere) {
    const Room made = room();
    const Scene moving =
        withClip(made.scene,
                 {track(AnimatedProperty::visible, made.scene.instances[made.ball].node, {1, 0})});
    Scene still = made.scene;
    still.instances.pop_back();
    FrameRequest r = request(moving, kMoving, {0, 0.6, 2.5});
    r.time = 1.5;
    request(still, kStill);
    for (const bool rays : {false, true}) {
        r.accuracy.planar = rays ? PlanarMethod::traced : PlanarMethod::mirror;
        r.accuracy.curved = rays ? CurvedMethod::traced : CurvedMethod::probe;
        r.effects.shadows = !rays;
        r.scene = kMoving;
        const Image hidden = renderer().render(r).image;
        r.scene = kStill;
        EXPECT_LE(differing(hidden, renderer().render(r).image), rays ? 6u : 0u);
    }
    renderer().removeScene(kMoving);
    renderer().removeScene(kStill);
}

TEST_F(AnimatedFactors, TheReferenceHasTheMoment) {
    const Room made = room();
    Scene moving = made.scene;
    moving.animatedLights = {{0, {.intensity = 8.0f}}};
    moving = withClip(
        moving, {track(AnimatedProperty::light, 0, {8, 24}, "intensity"),
                 track(AnimatedProperty::material, made.paint, {0.6f, 0.2f}, "roughness"),
                 track(AnimatedProperty::visible, made.scene.instances[made.ball].node, {1, 0})});
    Scene still = made.scene;
    still.lights[0].intensity = glm::vec3(22.0f);
    still.materials[made.paint].roughness = 0.25f;
    still.instances.pop_back();
    const auto black = builtinEnvironment("black");
    ASSERT_TRUE(black);
    const auto traced = [&](Scene scene, double time) {
        FrameRequest r = request(scene, kMoving, {0, 0.6, 2.5});
        r.time = time;
        r.width = r.height = 32;
        updateContentHash(scene);
        return traceReference(
                   {.scene = scene, .frame = r, .environment = *black, .samples = 2, .threads = 2},
                   {})
            ->color;
    };
    EXPECT_GT(differing(traced(moving, 0.0), traced(still, 0.0)), 40u);
    // Factors of the moment are floats between keys; paths are the same.
    const Image a = traced(moving, 1.75), b = traced(still, 0.0);
    EXPECT_LE(differing(a, b), 0u);
    renderer().removeScene(kMoving);
}

}  // namespace
}  // namespace clerestory::test
