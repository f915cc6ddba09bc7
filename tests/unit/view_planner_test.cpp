// Passes of flat mirrors.
#include "view_planner_support.h"

#include "plan/graph/features.h"
#include "plan/graph/work.h"

namespace clerestory::test {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// ---- scenes without reflectors -----------------------------------------------------------------

TEST(ViewPlanner, ASceneWithoutReflectorsHasNoPassAndNoTargetForThem) {
    const FramePlan plan = planOf(boxScene(dullGrey()), lookingFrom({0, 0, 5}));
    EXPECT_EQ(effectPasses(plan), 0u) << toText(plan);
    std::vector<std::string> names;
    for (const TargetSpec& t : plan.targets) names.push_back(t.name);
    EXPECT_THAT(names, ElementsAre("radiance", "environment:plain", "display", "filtered"));
    EXPECT_THAT(plan.decisions, IsEmpty());
    EXPECT_THAT(plan.skipped, skippedAs("mirrors", "the scene has no flat mirror"));
    EXPECT_THAT(plan.skipped, skippedAs("probes", "the scene has no curved mirror"));
    EXPECT_THAT(plan.skipped, skippedAs("glass", "the scene has no transmissive material"));
}

TEST(ViewPlanner, AlphaAloneIsNotGlass) {
    Material veil = dullGrey();
    veil.alphaMode = AlphaMode::blend;
    veil.baseColor.w = 0.3f;
    const FramePlan plan = planOf(boxScene(veil), forced(lookingFrom({0, 0, 5})));
    EXPECT_EQ(effectPasses(plan), 0u) << toText(plan);
    EXPECT_FALSE(rootOf(plan).blendedDraws.empty());
}

// ---- flat mirrors ------------------------------------------------------------------------------

TEST(ViewPlanner, AMirrorInViewAddsOnePassBeforeTheViewThatReadsIt) {
    const FramePlan plan = planOf(mirrorScene(), forced(lookingFrom({0.3, 0.2, 5})));
    ASSERT_EQ(count(plan, "mirror"), 1u) << toText(plan);
    const Pass mirror = passesOf(plan, "mirror")[0];
    const Pass root = passesOf(plan, "surface").at(0);
    EXPECT_THAT(root.reads(), Contains(mirror.target));
    EXPECT_EQ(rootOf(plan).reflections.at(0).target, mirror.target);
    EXPECT_LT(std::find(plan.passes.begin(), plan.passes.end(), mirror),
              std::find(plan.passes.begin(), plan.passes.end(), root));
    EXPECT_THAT(mirror.reason, HasSubstr("visible and facing"));
}

TEST(ViewPlanner, AMirroredViewTurnsTheWindingAndIsClippedAtTheMirror) {
    const FramePlan plan = planOf(mirrorScene(), forced(lookingFrom({0.3, 0.2, 5})));
    const View view = *passesOf(plan, "mirror").at(0).view();
    EXPECT_TRUE(view.mirrored);
    EXPECT_FALSE(rootOf(plan).view.mirrored);
    EXPECT_LT(glm::determinant(glm::dmat3(view.viewFromWorld)), 0.0);
    EXPECT_NEAR(view.eye.z, -5.0, 1e-12);
    ASSERT_TRUE(view.clipPlane.has_value());
    // The half-space in front of the mirror remains: z >= 0.
    const glm::dvec4 clip = *view.clipPlane;
    EXPECT_GT(glm::dot(glm::dvec3(clip), glm::dvec3(0, 0, 1e-6) - view.eye) + clip.w, 0.0);
    EXPECT_LT(glm::dot(glm::dvec3(clip), glm::dvec3(0, 0, -1e-6) - view.eye) + clip.w, 0.0);
    const auto mirrors = passesOf(plan, "mirror");  // outlives the loop over its draws
    for (const Draw& draw : std::get<DrawScene>(mirrors[0].work).opaqueDraws) {
        EXPECT_NE(draw.instance, 0u) << "the mirror itself";
    }
}

TEST(ViewPlanner, AMirrorInAMirrorTurnsTheWindingBack) {
    Scene scene = mirrorScene();
    placeAt(scene, scene.instances[0].mesh, turnedRound(0, 0, 9));
    const FramePlan plan = planOf(scene, forced(lookingFrom({0.3, 0.2, 5})));
    ASSERT_EQ(count(plan, "mirror"), 2u) << toText(plan);
    for (const Pass& pass : passesOf(plan, "mirror")) {
        EXPECT_EQ(pass.view()->mirrored, pass.generation % 2 == 1) << pass.generation;
    }
}

struct UnseenMirror {
    const char* how;
    const char* name;
    const char* reason;
    glm::dvec3 eye, target;
};

TEST(ViewPlanner, InvisibleMirrorsAddNoPass) {
    const char* mirrorName = "mirror:node";
    const UnseenMirror cases[] = {
        {"behind the camera", "mirrors", "no flat mirror in view", {0, 0, 5}, {0, 0, 9}},
        {"from its back", mirrorName, "seen from its back", {0, 0, -5}, {0, 0, 0}},
        {"in its own plane", mirrorName, "seen from its back", {5, 0, 0}, {0, 0, 0}},
        {"below a pixel", mirrorName, "smaller than a pixel", {0, 0, 4000}, {0, 0, 0}},
        {"edge-on", mirrorName, "a pixel", {5, 0, 1e-4}, {0, 0, 0}},
    };
    for (const UnseenMirror& c : cases) {
        const FramePlan plan = planOf(mirrorScene(), forced(lookingFrom(c.eye, c.target)));
        EXPECT_EQ(effectPasses(plan), 0u) << c.how << '\n' << toText(plan);
        EXPECT_THAT(plan.skipped, skippedAs(c.name, c.reason)) << c.how << '\n' << toText(plan);
    }
}

TEST(ViewPlanner, MirrorsBelowTheEyeAreEdgeOnOnlyBelowOnePixel) {
    // A floor around the eye, so large that its box is a part of the picture at any height.
    Scene scene;
    placeAt(scene, addSquareMesh(scene, "floor", addMaterial(scene, mirror())),
            glm::scale(glm::rotate(glm::dmat4(1.0), -glm::half_pi<double>(), glm::dvec3(1, 0, 0)),
                       glm::dvec3(50.0)),
            "floor");
    for (const double height : {1e-9, 1e-6, 1e-2, 1.0}) {
        FrameRequest request = forced(lookingFrom({0, height, 0}, {1, height, 0}));
        request.camera.znear = 0.01;
        const FramePlan plan = planOf(scene, request);
        const bool seen = height > 1e-3;
        EXPECT_EQ(count(plan, "mirror"), seen ? 1u : 0u) << height << '\n' << toText(plan);
        if (!seen) {
            EXPECT_THAT(plan.skipped, skippedAs("mirror:floor", ""));
        }
    }
}

TEST(ViewPlanner, ObjectsBehindAMirrorAddNoPass) {
    Scene scene = mirrorScene();
    // Another mirror, a ball and a box behind the first one's plane, and one in the plane.
    placeAt(scene, scene.instances[0].mesh, at(0, 1.5, -0.5), "behind");
    placeAt(scene, scene.instances[0].mesh, glm::rotate(at(0, -1, -1), 1.5, {1, 0, 0}), "touching");
    placeAt(scene, addBallMesh(scene, "ball", addMaterial(scene, mirror())), at(2, 0, -1), "ball");
    FrameRequest request = forced(lookingFrom({0, 0, 5}));
    request.accuracy.generations = 1;
    for (const Pass& pass : passesOf(planOf(scene, request), "mirror")) {
        if (pass.name != "mirror:node") continue;
        for (const Draw& draw : std::get<DrawScene>(pass.work).opaqueDraws) {
            EXPECT_THAT(draw.instance, testing::AnyOf(1u, 2u)) << "the two boxes before it";
        }
    }
}

TEST(ViewPlanner, ATwoSidedMirrorIsSeenFromItsBack) {
    Material sheet = mirror();
    sheet.doubleSided = true;
    const FramePlan plan = planOf(mirrorScene(sheet), forced(lookingFrom({0, 0, -5})));
    EXPECT_EQ(count(plan, "mirror"), 1u) << toText(plan);
}

TEST(ViewPlanner, SwitchedOffMirrorsAddNoPassAndAReason) {
    FrameRequest request = forced(lookingFrom({0, 0, 5}));
    request.effects.planarReflection = false;
    const FramePlan plan = planOf(mirrorScene(), request);
    EXPECT_EQ(effectPasses(plan), 0u);
    EXPECT_THAT(plan.skipped, skippedAs("mirrors", "switched off"));

    Material refused = mirror();
    refused.reflection = Reflection::none;
    Scene without = mirrorScene(refused);
    EXPECT_EQ(rootOf(plan), rootOf(planOf(without, request))) << "as a scene without mirrors";
}

TEST(ViewPlanner, ImperceptibleMirrorsAddNoPassEvenIfRequested) {
    // A polished floor with the index of water, a thousandth of the picture.
    Material water{.name = "water", .metallic = 0.0f, .roughness = 0.0f, .ior = 1.02f};
    const FramePlan plan = planOf(mirrorScene(water), forced(lookingFrom({0, 0, 20})));
    EXPECT_EQ(effectPasses(plan), 0u);
    EXPECT_THAT(plan.skipped, skippedAs("mirror:node", "weight below the visible minimum"));
}

TEST(ViewPlanner, MirrorsInOnePlaneShareOnePicture) {
    Scene scene = mirrorScene();
    const Index square = scene.instances[0].mesh;
    placeAt(scene, square, at(2.5, 0, 0));
    placeAt(scene, square, glm::rotate(at(-2.5, 0, 0), 0.3, glm::dvec3(0, 0, 1)));
    const FrameRequest request = forced(lookingFrom({0, 0, 8}));
    const FramePlan shared = planOf(scene, request);
    EXPECT_EQ(count(shared, "mirror"), 1u) << toText(shared);
    placeAt(scene, square, at(0, 2.5, 0.01));  // a centimetre in front
    EXPECT_EQ(count(planOf(scene, request), "mirror"), 2u);
}

TEST(ViewPlanner, FacingMirrorsFollowTheRequestedGenerations) {
    Scene scene;
    const Index square = addSquareMesh(scene, "mirror", addMaterial(scene, mirror()));
    placeAt(scene, square, at(0, 0, -1));
    placeAt(scene, square, turnedRound(0, 0, 1));
    for (std::uint32_t generations = 1; generations <= 6; ++generations) {
        FrameRequest request = forced(lookingFrom({0, 0, 0}, {0, 0, -1}));
        request.accuracy.generations = generations;
        const std::vector<Pass> passes = passesOf(planOf(scene, request), "mirror");
        ASSERT_EQ(passes.size(), generations);
        for (std::size_t i = 0; i < passes.size(); ++i) {
            EXPECT_EQ(passes[i].generation, generations - i) << "the deepest is drawn first";
        }
    }
}

TEST(ViewPlanner, WideViewsBetweenFacingMirrorsFollowBothDirections) {
    // Both mirrors are in view from between them, each with a chain of views: 2 g passes.
    Scene scene;
    const Index square = addSquareMesh(scene, "mirror", addMaterial(scene, mirror()));
    const auto wall = [&](double x, double turn) {
        placeAt(
            scene, square,
            glm::scale(glm::rotate(at(x, 0, -20), turn, glm::dvec3(0, 1, 0)), glm::dvec3(20.0)));
    };
    wall(-1, glm::half_pi<double>());
    wall(1, -glm::half_pi<double>());
    for (std::uint32_t generations = 1; generations <= 4; ++generations) {
        FrameRequest request = forced(lookingFrom({0, 0, 1}, {0, 0, -1}));
        request.accuracy.generations = generations;
        EXPECT_EQ(count(planOf(scene, request), "mirror"), 2 * generations);
    }
}

TEST(ViewPlanner, ARoughMirrorHasLevelsAndASharpOneHasNone) {
    const FrameRequest request = forced(lookingFrom({0, 0, 5}));
    const FramePlan sharp = planOf(mirrorScene(), request);
    EXPECT_EQ(count(sharp, "levels"), 0u);
    const FramePlan rough = planOf(mirrorScene(mirror(0.3f)), request);
    ASSERT_EQ(count(rough, "levels"), 1u);
    EXPECT_GT(rough.targets[passesOf(rough, "levels")[0].target].levels, 1u);
}

TEST(ViewPlanner, MirroredViewsAreLimitedToTheVisiblePart) {
    FrameRequest request = forced(lookingFrom({0, 0, 8}));
    const auto target = [&] {
        const FramePlan plan = planOf(mirrorScene(), request);
        return plan.targets[passesOf(plan, "mirror").at(0).target];
    };
    const TargetSpec whole = target();
    EXPECT_LT(whole.width, request.width / 2);
    EXPECT_LT(whole.height, request.height / 2);
    request.accuracy.planarScale = 0.5;
    EXPECT_NEAR(target().width, 0.5 * whole.width, 1.0);
}

TEST(ViewPlanner, AnOverrideMakesAMatteFloorAMirror) {
    const Scene scene = mirrorScene(dullGrey());
    FrameRequest request = lookingFrom({0, 0, 5});
    EXPECT_EQ(effectPasses(planOf(scene, request)), 0u);
    MaterialOverride polished;
    polished.material = "grey";
    polished.metallic = 1.0;
    polished.roughness = 0.0;
    request.overrides = {polished};
    const FramePlan plan = planOf(scene, forced(request));
    EXPECT_GE(count(plan, "mirror"), 1u) << toText(plan);
    MaterialOverride said;
    said.material = "grey";
    said.reflection = Reflection::mirror;
    request.overrides = {said};
    EXPECT_GE(count(planOf(scene, forced(request)), "mirror"), 1u);
}

// A table: two slabs of two-sided thin-walled glass, a hand above each other, on four metal legs.
Scene glassTable(float thickness) {
    Scene scene;
    Material glass = clearGlass();
    glass.doubleSided = true;
    glass.alphaMode = AlphaMode::blend;
    glass.baseColor.w = 0.25f;
    const Index slab = addBoxMesh(scene, "slab", addMaterial(scene, glass));
    const Index leg = addBoxMesh(scene, "leg", addMaterial(scene, mirror(0.2f)));
    const auto put = [&](Index mesh, double x, double y, double z, const glm::dvec3& half) {
        placeAt(scene, mesh, glm::scale(at(x, y, z), half), mesh == slab ? "slab" : "leg");
    };
    put(slab, 0, 1.2, 0, {2.0, 0.5 * thickness, 1.1});
    put(slab, 0, 0.4, 0, {1.8, 0.5 * thickness, 0.9});
    for (const double x : {-1.5, 1.5}) {
        for (const double z : {-0.7, 0.7}) put(leg, x, 0.6, z, {0.1, 0.6, 0.1});
    }
    return scene;
}

TEST(ViewPlanner, AGlassTableNeedsFewBackdrops) {
    FrameRequest request = lookingFrom({3, 3, 4}, {0, 0.7, 0});
    request.width = 640;
    request.height = 400;
    const FramePlan plan = planOf(glassTable(0.03f), request);
    // The two slabs and the cost of two of the legs' sides; each with the cost of a mirror in it.
    EXPECT_LE(count(plan, "mirror"), 10u) << toText(plan);
    EXPECT_LE(plan.passes.size(), 40u) << toText(plan);
    const auto of = [&](const std::string& words) {
        return std::count_if(plan.passes.begin(), plan.passes.end(), [&](const Pass& pass) {
            return pass.kind() == "mirror" && pass.generation == 1 &&
                   pass.reason.find(words) != std::string::npos;
        });
    };
    EXPECT_EQ(of("for both sides of a sheet"), 2) << toText(plan);
    // Partial coverage applies to the transmission as well.
    for (const Pass& pass : plan.passes) {
        const auto* glass = std::get_if<DrawGlass>(&pass.work);
        if (!glass) continue;
        for (const Draw& draw : glass->glassDraws) EXPECT_TRUE(draw.features & FEATURE_BLEND);
    }
    // One decision for each slab, not one for each of its sides.
    const auto glass = std::count_if(plan.decisions.begin(), plan.decisions.end(),
                                     [](const Decision& d) { return d.name == "glass:slab"; });
    EXPECT_EQ(glass, 2);
}

TEST(ViewPlanner, DistantSidesHaveSeparateBackdrops) {
    FrameRequest request = forced(lookingFrom({3, 3, 4}, {0, 0.7, 0}));
    const auto sheets = [&](float thickness) {
        const FramePlan plan = planOf(glassTable(thickness), request);
        return std::count_if(plan.passes.begin(), plan.passes.end(), [](const Pass& pass) {
            return pass.reason.find("both sides") != std::string::npos;
        });
    };
    EXPECT_GT(sheets(0.01f), 0);
    EXPECT_EQ(sheets(0.6f), 0);
}

TEST(ViewPlanner, TheStrongestMirrorsAreDrawnAndTheOthersReported) {
    Scene scene;
    const Index square = addSquareMesh(scene, "mirror", addMaterial(scene, mirror()));
    // Twelve squares in a row, each a little farther away.
    for (int i = 0; i < 12; ++i) {
        placeAt(scene, square, glm::scale(at(-5.5 + i, 0, -0.3 * i), glm::dvec3(0.45)));
    }
    const FramePlan plan = planOf(scene, forced(lookingFrom({0, 0, 9})));
    EXPECT_EQ(count(plan, "mirror"), 8u) << toText(plan);
    const auto left = std::count_if(plan.skipped.begin(), plan.skipped.end(), [](const Skipped& s) {
        return s.reason.find("weaker than the 8 mirrors") != std::string::npos;
    });
    EXPECT_EQ(left, 4);
}

// ---- all plans ---------------------------------------------------------------------------------

TEST(ViewPlanner, EqualRequestsGiveEqualPlansForAnyContent) {
    Scene scene = ballScene();
    placeAt(scene, addSquareMesh(scene, "pane", addMaterial(scene, clearGlass(0.3f))), at(0, 0, 3),
            "pane");
    placeAt(scene, addSquareMesh(scene, "mirror", addMaterial(scene, mirror(0.2f))), at(0, 0, -5),
            "mirror");
    const FrameRequest request = lookingFrom({0, 1, 7});
    EXPECT_EQ(planOf(scene, request), planOf(scene, request));
    const FramePlan plan = planOf(scene, forced(request));
    EXPECT_EQ(plan, planOf(scene, forced(request)));
    for (const Pass& pass : plan.passes) EXPECT_FALSE(pass.reason.empty()) << pass.name;
}

}  // namespace
}  // namespace clerestory::test
