// Shadows in scenes with clips: what does not change is drawn once, and pictures equal those of the
// same scene at rest.
#include "plan/graph/frame_plan.h"
#include "support.h"

#include <algorithm>
#include <string>
#include <string_view>

using namespace clerestory;
using namespace clerestory::test;

namespace {

class MovingShadows : public GlTest {};

enum class Moves { square, pane, lamp, lampAndSquare, far };

// A square before a wall that a lamp lights, and something that moves by 1 to the right in 2 s. If
// `at` is set, the scene has no clip, and the latter is where it is at that time.
Scene sceneWith(Moves what, LightKind kind, std::optional<double> at = std::nullopt) {
    Scene scene;
    place(scene, quad(2.0f, addMaterial(scene, lambertBothSides(0.5f))));
    place(scene, quad(0.15f, addMaterial(scene, lambertBothSides(0.5f))), moved(0.0, 0.5, 1.0));
    const glm::vec3 from(-0.5f, 0.0f, 0.8f);
    const glm::vec3 to = from + glm::vec3(what == Moves::far ? 100.0f : 1.0f, 0.0f, 0.0f);
    const glm::vec3 now = glm::mix(from, to, static_cast<float>(at.value_or(0.0) / 2.0));
    const auto lampAt = [&](const glm::dvec3& place) {
        addLight(scene, {.kind = kind, .intensity = glm::vec3(4.0f)},
                 moved(place.x, place.y, place.z));
    };
    if (what == Moves::lampAndSquare) {
        place(scene, quad(0.2f, addMaterial(scene, lambertBothSides(0.5f))));
        moveLast(scene, from - glm::vec3(0.0f, 0.5f, 0.0f), to);
        scene.clips.back().name = "square";
    }
    if (what == Moves::lamp || what == Moves::lampAndSquare) {
        lampAt(now);
    } else {
        lampAt({0.0, 0.0, 3.0});
        Material m = lambertBothSides(0.5f);
        if (what == Moves::pane) {
            m.baseColor = glm::vec4(1.0f, 0.3f, 0.3f, 1.0f);
            m.transmission = 1.0f;
        }
        place(scene, quad(0.2f, addMaterial(scene, std::move(m))), moved(now.x, now.y, now.z));
    }
    if (!at) moveLast(scene, from, to);
    return scene;
}

FrameRequest shadowed(Scene scene, const std::string& id) {
    FrameRequest r = request(std::move(scene), id, {0.0, 0.0, 2.0});
    r.effects.shadows = true;
    r.width = r.height = 128;
    return r;
}

struct ShadowPasses {
    std::ptrdiff_t still, shadows, tints;
    bool operator==(const ShadowPasses&) const = default;
};
void PrintTo(const ShadowPasses& p, std::ostream* out) {
    *out << p.still << " still, " << p.shadows << " shadows, " << p.tints << " tints";
}

ShadowPasses shadowPassesOf(FrameRequest r, double time) {
    r.time = time;
    const FramePlan plan = renderer().plan(r);
    const auto named = [&](std::string_view start) {
        return std::count_if(plan.passes.begin(), plan.passes.end(), [&](const Pass& pass) {
            return std::string_view(pass.name).substr(0, start.size()) == start;
        });
    };
    return {named("stillShadows:"), named("shadows:"), named("shadowTints:")};
}

Image drawnAt(FrameRequest r, double time) {
    r.time = time;
    return renderer().render(r).image;
}

TEST_F(MovingShadows, WhatDoesNotChangeIsDrawnOnce) {
    const FrameRequest r = shadowed(sceneWith(Moves::square, LightKind::point), "moving square");
    EXPECT_EQ(shadowPassesOf(r, 0.0), (ShadowPasses{6, 6, 0}));
    drawnAt(r, 0.0);
    EXPECT_EQ(shadowPassesOf(r, 0.0), (ShadowPasses{0, 0, 0}));
    EXPECT_EQ(shadowPassesOf(r, 1.0), (ShadowPasses{0, 6, 0}));
    FrameRequest later = r;
    later.time = 1.0;
    std::size_t draws = 0;
    for (const Pass& pass : renderer().plan(later).passes) {
        const auto* shadow = std::get_if<DrawShadow>(&pass.work);
        if (!shadow) continue;
        for (const Draw& draw : shadow->draws) EXPECT_EQ(draw.instance, 2u);
        draws += shadow->draws.size();
    }
    EXPECT_GT(draws, 0u);
}

TEST_F(MovingShadows, WhatCastsNoneLeavesTheMapAlone) {
    const FrameRequest r = shadowed(sceneWith(Moves::pane, LightKind::point), "moving pane");
    EXPECT_EQ(shadowPassesOf(r, 0.0), (ShadowPasses{0, 6, 6}));
    drawnAt(r, 0.0);
    EXPECT_EQ(shadowPassesOf(r, 1.0), (ShadowPasses{0, 0, 6}));
}

TEST_F(MovingShadows, AMovingLampSeesEverythingAgain) {
    for (const Moves what : {Moves::lamp, Moves::lampAndSquare}) {
        const FrameRequest r = shadowed(sceneWith(what, LightKind::point), "moving lamp");
        EXPECT_EQ(shadowPassesOf(r, 0.0), (ShadowPasses{0, 6, 0}));
        drawnAt(r, 0.0);
        EXPECT_EQ(shadowPassesOf(r, 1.0), (ShadowPasses{0, 6, 0}));
    }
}

// The picture of the sun shows all places of the square, unless it goes far away.
TEST_F(MovingShadows, TheSunSeesWhereItWillBe) {
    const FrameRequest near = shadowed(sceneWith(Moves::square, LightKind::directional), "near");
    drawnAt(near, 0.0);
    EXPECT_EQ(shadowPassesOf(near, 1.0), (ShadowPasses{0, 1, 0}));
    const FrameRequest far = shadowed(sceneWith(Moves::far, LightKind::directional), "far");
    EXPECT_EQ(shadowPassesOf(far, 0.0), (ShadowPasses{0, 1, 0}));
    EXPECT_GT(differing(drawnAt(far, 0.0), drawnAt(far, 0.1)), 50u);
}

TEST_F(MovingShadows, EqualThoseOfTheSceneAtRest) {
    for (const Moves what : {Moves::square, Moves::pane, Moves::lamp}) {
        for (const bool rays : {false, true}) {
            FrameRequest moving = shadowed(sceneWith(what, LightKind::point), "moving");
            FrameRequest still = shadowed(sceneWith(what, LightKind::point, 1.5), "still");
            if (rays) {  // hits read the processor's copy of the maps
                moving.accuracy.curved = still.accuracy.curved = CurvedMethod::traced;
                moving.accuracy.glass = still.accuracy.glass = GlassMethod::traced;
            }
            const Image before = drawnAt(moving, 0.0);
            const Image after = drawnAt(moving, 1.5);
            EXPECT_GT(differing(before, after), 50u);
            EXPECT_EQ(differing(after, drawnAt(still, 0.0)), 0u) << static_cast<int>(what);
        }
    }
}

}  // namespace
