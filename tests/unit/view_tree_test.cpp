// What reflectors and glass make a frame do, and what they do not: plan rules as sentences.
#include "plan_scenes.h"

#include "plan/features.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <set>

namespace clerestory::test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;

Material mirror(float roughness = 0.0f) {
    return {.name = "mirror", .metallic = 1.0f, .roughness = roughness};
}
Material clearGlass(float roughness = 0.0f) {
    return {.name = "glass", .metallic = 0.0f, .roughness = roughness, .transmission = 1.0f};
}
Material dullGrey() {
    return {.name = "grey", .metallic = 0.0f};
}

glm::dmat4 at(double x, double y, double z) {
    return glm::translate(glm::dmat4(1.0), glm::dvec3(x, y, z));
}
// Facing -Z.
glm::dmat4 turnedRound(double x, double y, double z) {
    return glm::rotate(at(x, y, z), glm::pi<double>(), glm::dvec3(0, 1, 0));
}

// A mirror of 2 x 2 metres in the plane z = 0 and two boxes in front of it.
Scene mirrorScene(Material material = mirror()) {
    Scene scene;
    placeAt(scene, addSquareMesh(scene, "mirror", addMaterial(scene, std::move(material))),
            at(0, 0, 0));
    const Index box = addBoxMesh(scene, "box", addMaterial(scene, dullGrey()));
    place(scene, box, {-0.8, 0, 1.5}, 0.2);
    place(scene, box, {0.8, 0, 2.5}, 0.2);
    updateContentHash(scene);
    return scene;
}

// Two mirror balls and a grey box, each in view of the other two.
Scene ballScene() {
    Scene scene;
    const Index ball = addBallMesh(scene, "ball", addMaterial(scene, mirror()));
    placeAt(scene, ball, at(-1.5, 0, 0), "left");
    placeAt(scene, ball, at(1.5, 0, 0), "right");
    placeAt(scene, addBoxMesh(scene, "box", addMaterial(scene, dullGrey())), at(0, 0, -3), "box");
    updateContentHash(scene);
    return scene;
}

FrameRequest forced(FrameRequest request) {
    request.accuracy.planar = PlanarMethod::mirror;
    request.accuracy.curved = CurvedMethod::probe;
    request.accuracy.glass = GlassMethod::backdrop;
    return request;
}

std::vector<Pass> passesOf(const FramePlan& plan, PassKind kind) {
    std::vector<Pass> result;
    std::copy_if(plan.passes.begin(), plan.passes.end(), std::back_inserter(result),
                 [&](const Pass& pass) { return pass.kind == kind; });
    return result;
}
std::size_t count(const FramePlan& plan, PassKind kind) {
    return passesOf(plan, kind).size();
}
Pass rootOf(const FramePlan& plan) {
    return passesOf(plan, PassKind::surface).at(0);
}

// Keys of all maps that outlive the frame, but the environment's.
std::set<std::uint64_t> probeKeys(const FramePlan& plan) {
    std::set<std::uint64_t> keys;
    for (const TargetSpec& t : plan.targets) {
        if (t.residentKey != 0 && t.name.starts_with("probe:")) keys.insert(t.residentKey);
    }
    return keys;
}
ResidentMaps allOf(const FramePlan& plan) {
    ResidentMaps maps;
    for (const TargetSpec& t : plan.targets) {
        if (t.residentKey != 0) maps.keys.insert(t.residentKey);
    }
    return maps;
}

std::uint64_t effectPasses(const FramePlan& plan) {
    std::uint64_t sum = 0;
    for (const PassKind kind : {PassKind::mirror, PassKind::capture, PassKind::prefilter,
                                PassKind::levels, PassKind::backdrop, PassKind::glass}) {
        sum += count(plan, kind);
    }
    return sum;
}

auto skippedAs(const std::string& name, const std::string& reason) {
    return Contains(AllOf(Field(&Skipped::name, name), Field(&Skipped::reason, HasSubstr(reason))));
}

// ---- nothing for nothing -----------------------------------------------------------------------

TEST(ViewTree, ASceneWithoutReflectorsHasNoPassAndNoTargetForThem) {
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

TEST(ViewTree, AlphaAloneIsNoGlass) {
    Material veil = dullGrey();
    veil.alphaMode = AlphaMode::blend;
    veil.baseColor.w = 0.3f;
    const FramePlan plan = planOf(boxScene(veil), forced(lookingFrom({0, 0, 5})));
    EXPECT_EQ(effectPasses(plan), 0u) << toText(plan);
    EXPECT_FALSE(rootOf(plan).blendedDraws.empty());
}

// ---- flat mirrors ------------------------------------------------------------------------------

TEST(ViewTree, AMirrorInViewAddsOnePassBeforeTheViewThatReadsIt) {
    const FramePlan plan = planOf(mirrorScene(), forced(lookingFrom({0.3, 0.2, 5})));
    ASSERT_EQ(count(plan, PassKind::mirror), 1u) << toText(plan);
    const Pass mirror = passesOf(plan, PassKind::mirror)[0];
    const Pass root = rootOf(plan);
    EXPECT_THAT(root.reads, Contains(mirror.target));
    EXPECT_EQ(root.reflections.at(0).target, mirror.target);
    EXPECT_LT(std::find(plan.passes.begin(), plan.passes.end(), mirror),
              std::find(plan.passes.begin(), plan.passes.end(), root));
    EXPECT_THAT(mirror.reason, HasSubstr("visible, facing"));
}

TEST(ViewTree, AMirroredViewTurnsTheWindingAndIsClippedAtTheMirror) {
    const FramePlan plan = planOf(mirrorScene(), forced(lookingFrom({0.3, 0.2, 5})));
    const View view = passesOf(plan, PassKind::mirror).at(0).views.at(0);
    EXPECT_TRUE(view.mirrored);
    EXPECT_FALSE(rootOf(plan).views.at(0).mirrored);
    EXPECT_LT(glm::determinant(glm::dmat3(view.viewFromWorld)), 0.0);
    EXPECT_NEAR(view.eye.z, -5.0, 1e-12);
    ASSERT_TRUE(view.clipPlane.has_value());
    // Kept is what lies in front of the mirror: z >= 0.
    const glm::dvec4 clip = *view.clipPlane;
    EXPECT_GT(glm::dot(glm::dvec3(clip), glm::dvec3(0, 0, 1e-6) - view.eye) + clip.w, 0.0);
    EXPECT_LT(glm::dot(glm::dvec3(clip), glm::dvec3(0, 0, -1e-6) - view.eye) + clip.w, 0.0);
    const auto mirrors = passesOf(plan, PassKind::mirror);  // outlives the loop over its draws
    for (const Draw& draw : mirrors[0].opaqueDraws) {
        EXPECT_TRUE(draw.features & FEATURE_CLIP);
        EXPECT_NE(draw.instance, 0u) << "the mirror itself";
    }
}

TEST(ViewTree, AMirrorInAMirrorTurnsTheWindingBack) {
    Scene scene = mirrorScene();
    placeAt(scene, scene.instances[0].mesh, turnedRound(0, 0, 9));
    const FramePlan plan = planOf(scene, forced(lookingFrom({0.3, 0.2, 5})));
    ASSERT_EQ(count(plan, PassKind::mirror), 2u) << toText(plan);
    for (const Pass& pass : passesOf(plan, PassKind::mirror)) {
        EXPECT_EQ(pass.views[0].mirrored, pass.generation % 2 == 1) << pass.generation;
    }
}

struct UnseenMirror {
    const char* how;
    const char* name;
    const char* reason;
    glm::dvec3 eye, target;
};

TEST(ViewTree, AMirrorThatNobodySeesAddsNoPass) {
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

TEST(ViewTree, AMirrorUnderTheEyesOwnFeetIsEdgeOnOnlyBelowAPixelsHeight) {
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
        EXPECT_EQ(count(plan, PassKind::mirror), seen ? 1u : 0u) << height << '\n' << toText(plan);
        if (!seen) {
            EXPECT_THAT(plan.skipped, skippedAs("mirror:floor", ""));
        }
    }
}

TEST(ViewTree, WhatStandsBehindAMirrorAsksForNothing) {
    Scene scene = mirrorScene();
    // Another mirror, a ball and a box behind the first one's plane, and one in the plane.
    placeAt(scene, scene.instances[0].mesh, at(0, 1.5, -0.5), "behind");
    placeAt(scene, scene.instances[0].mesh, glm::rotate(at(0, -1, -1), 1.5, {1, 0, 0}), "touching");
    placeAt(scene, addBallMesh(scene, "ball", addMaterial(scene, mirror())), at(2, 0, -1), "ball");
    FrameRequest request = forced(lookingFrom({0, 0, 5}));
    request.accuracy.generations = 1;
    for (const Pass& pass : passesOf(planOf(scene, request), PassKind::mirror)) {
        if (pass.name != "mirror:node") continue;
        for (const Draw& draw : pass.opaqueDraws) {
            EXPECT_THAT(draw.instance, testing::AnyOf(1u, 2u)) << "the two boxes before it";
        }
    }
}

TEST(ViewTree, ATwoSidedMirrorIsSeenFromItsBack) {
    Material sheet = mirror();
    sheet.doubleSided = true;
    const FramePlan plan = planOf(mirrorScene(sheet), forced(lookingFrom({0, 0, -5})));
    EXPECT_EQ(count(plan, PassKind::mirror), 1u) << toText(plan);
}

TEST(ViewTree, AMirrorThatIsSwitchedOffAddsNoPassAndSaysSo) {
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

TEST(ViewTree, AMirrorTooWeakToBeSeenAddsNoPassEvenWhenAskedFor) {
    // A polished floor of water's index, straight ahead, a thousandth of the picture.
    Material water{.name = "water", .metallic = 0.0f, .roughness = 0.0f, .ior = 1.02f};
    const FramePlan plan = planOf(mirrorScene(water), forced(lookingFrom({0, 0, 20})));
    EXPECT_EQ(effectPasses(plan), 0u);
    EXPECT_THAT(plan.skipped, skippedAs("mirror:node", "too weak or too small"));
}

TEST(ViewTree, MirrorsInOnePlaneShareOnePicture) {
    Scene scene = mirrorScene();
    const Index square = scene.instances[0].mesh;
    placeAt(scene, square, at(2.5, 0, 0));
    placeAt(scene, square, glm::rotate(at(-2.5, 0, 0), 0.3, glm::dvec3(0, 0, 1)));
    const FrameRequest request = forced(lookingFrom({0, 0, 8}));
    const FramePlan shared = planOf(scene, request);
    EXPECT_EQ(count(shared, PassKind::mirror), 1u) << toText(shared);
    placeAt(scene, square, at(0, 2.5, 0.01));  // a centimetre in front
    EXPECT_EQ(count(planOf(scene, request), PassKind::mirror), 2u);
}

TEST(ViewTree, FacingMirrorsShowEachOtherForAsManyGenerationsAsAskedFor) {
    Scene scene;
    const Index square = addSquareMesh(scene, "mirror", addMaterial(scene, mirror()));
    placeAt(scene, square, at(0, 0, -1));
    placeAt(scene, square, turnedRound(0, 0, 1));
    for (std::uint32_t generations = 1; generations <= 6; ++generations) {
        FrameRequest request = forced(lookingFrom({0, 0, 0}, {0, 0, -1}));
        request.accuracy.generations = generations;
        const std::vector<Pass> passes = passesOf(planOf(scene, request), PassKind::mirror);
        ASSERT_EQ(passes.size(), generations);
        for (std::size_t i = 0; i < passes.size(); ++i) {
            EXPECT_EQ(passes[i].generation, generations - i) << "the deepest is drawn first";
        }
    }
}

TEST(ViewTree, AWideViewBetweenFacingMirrorsFollowsBothWays) {
    // Both mirrors in view from between them: each way its own chain, so 2 g passes.
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
        EXPECT_EQ(count(planOf(scene, request), PassKind::mirror), 2 * generations);
    }
}

TEST(ViewTree, ARoughMirrorHasLevelsAndASharpOneHasNone) {
    const FrameRequest request = forced(lookingFrom({0, 0, 5}));
    const FramePlan sharp = planOf(mirrorScene(), request);
    EXPECT_EQ(count(sharp, PassKind::levels), 0u);
    const FramePlan rough = planOf(mirrorScene(mirror(0.3f)), request);
    ASSERT_EQ(count(rough, PassKind::levels), 1u);
    EXPECT_GT(rough.targets[passesOf(rough, PassKind::levels)[0].target].levels, 1u);
}

TEST(ViewTree, AMirrorsPictureIsNoLargerThanThePartOfTheViewThatShowsIt) {
    FrameRequest request = forced(lookingFrom({0, 0, 8}));
    const auto target = [&] {
        const FramePlan plan = planOf(mirrorScene(), request);
        return plan.targets[passesOf(plan, PassKind::mirror).at(0).target];
    };
    const TargetSpec whole = target();
    EXPECT_LT(whole.width, request.width / 2);
    EXPECT_LT(whole.height, request.height / 2);
    request.accuracy.planarScale = 0.5;
    EXPECT_NEAR(target().width, 0.5 * whole.width, 1.0);
}

TEST(ViewTree, AnOverrideMakesAMatteFloorAMirror) {
    const Scene scene = mirrorScene(dullGrey());
    FrameRequest request = lookingFrom({0, 0, 5});
    EXPECT_EQ(effectPasses(planOf(scene, request)), 0u);
    MaterialOverride polished;
    polished.material = "grey";
    polished.metallic = 1.0;
    polished.roughness = 0.0;
    request.overrides = {polished};
    const FramePlan plan = planOf(scene, forced(request));
    EXPECT_GE(count(plan, PassKind::mirror), 1u) << toText(plan);
    MaterialOverride said;
    said.material = "grey";
    said.reflection = Reflection::mirror;
    request.overrides = {said};
    EXPECT_GE(count(planOf(scene, forced(request)), PassKind::mirror), 1u);
}

namespace {

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

}  // namespace

TEST(ViewTree, AGlassTableIsServedByAHandfulOfPictures) {
    FrameRequest request = lookingFrom({3, 3, 4}, {0, 0.7, 0});
    request.width = 640;
    request.height = 400;
    const FramePlan plan = planOf(glassTable(0.03f), request);
    // Of the two slabs and what two of the legs' sides are worth; each of them with what a mirror
    // in it is worth.
    EXPECT_LE(count(plan, PassKind::mirror), 10u) << toText(plan);
    EXPECT_LE(plan.passes.size(), 40u) << toText(plan);
    const auto of = [&](const std::string& words) {
        return std::count_if(plan.passes.begin(), plan.passes.end(), [&](const Pass& pass) {
            return pass.kind == PassKind::mirror && pass.generation == 1 &&
                   pass.reason.find(words) != std::string::npos;
        });
    };
    EXPECT_EQ(of("for both sides of a sheet"), 2) << toText(plan);
    // What covers a part of it, covers what it lets through, too.
    for (const Pass& pass : plan.passes) {
        if (pass.kind != PassKind::glass) continue;
        for (const Draw& draw : pass.opaqueDraws) EXPECT_TRUE(draw.features & FEATURE_BLEND);
    }
    // One decision for each slab, not one for each of its sides.
    const auto glass = std::count_if(plan.decisions.begin(), plan.decisions.end(),
                                     [](const Decision& d) { return d.name == "glass:slab"; });
    EXPECT_EQ(glass, 2);
}

TEST(ViewTree, SidesThatStandFarApartHaveAPictureEach) {
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

TEST(ViewTree, OfManyMirrorsTheStrongestHaveAPictureAndTheOthersAreNamed) {
    Scene scene;
    const Index square = addSquareMesh(scene, "mirror", addMaterial(scene, mirror()));
    // Twelve squares in a row, each a little farther away.
    for (int i = 0; i < 12; ++i) {
        placeAt(scene, square, glm::scale(at(-5.5 + i, 0, -0.3 * i), glm::dvec3(0.45)));
    }
    const FramePlan plan = planOf(scene, forced(lookingFrom({0, 0, 9})));
    EXPECT_EQ(count(plan, PassKind::mirror), 8u) << toText(plan);
    const auto left = std::count_if(plan.skipped.begin(), plan.skipped.end(), [](const Skipped& s) {
        return s.reason.find("weaker than the 8 mirrors") != std::string::npos;
    });
    EXPECT_EQ(left, 4);
}

// ---- captured cubes ----------------------------------------------------------------------------

TEST(ViewTree, TwoCurvedMirrorsAndTwoGenerationsAre24FaceViewsTheFirstGenerationFirst) {
    const FramePlan plan = planOf(ballScene(), forced(lookingFrom({0, 1, 6})));
    const std::vector<Pass> faces = passesOf(plan, PassKind::capture);
    ASSERT_EQ(faces.size(), 24u) << toText(plan);
    EXPECT_EQ(count(plan, PassKind::prefilter), 4u);
    // Whoever shows a cube comes after it, and a first generation shows none.
    std::set<TargetId> finished;
    for (const Pass& pass : plan.passes) {
        if (pass.kind == PassKind::prefilter) finished.insert(pass.target);
        if (pass.kind != PassKind::capture) continue;
        if (pass.generation == 1) {
            EXPECT_TRUE(pass.reflections.empty()) << toText(plan);
        }
        for (const ReflectedPicture& r : pass.reflections) {
            EXPECT_TRUE(finished.contains(r.target)) << pass.name << " reads what is not drawn";
        }
    }
}

TEST(ViewTree, ResidentCubesAreNotDrawnAgainFromWhereverTheyAreSeen) {
    const Scene scene = ballScene();
    const FramePlan first = planOf(scene, forced(lookingFrom({0, 1, 6})));
    const FramePlan second = planOf(scene, forced(lookingFrom({1, 2, 5})), allOf(first));
    EXPECT_EQ(count(second, PassKind::capture), 0u) << toText(second);
    EXPECT_EQ(count(second, PassKind::prefilter), 0u);
    EXPECT_EQ(count(second, PassKind::levels), 0u);
    EXPECT_EQ(count(second, PassKind::environment), 0u);
    EXPECT_THAT(second.skipped, skippedAs("probe:left", "resident and unchanged"));
    EXPECT_EQ(rootOf(second).reflections.size(), 2u) << "still read";
    for (const std::uint64_t key : probeKeys(second)) {
        EXPECT_TRUE(allOf(first).keys.contains(key));
    }
}

TEST(ViewTree, ACubesKeyIsThatOfWhatItSees) {
    const Scene scene = ballScene();
    FrameRequest request = forced(lookingFrom({0, 1, 6}));
    request.accuracy.generations = 1;
    const auto keysOf = [&](const Pose& pose, const FrameRequest& r) {
        return probeKeys(planFrame(scene, pose, r, plainMap(), {}, DeviceLimits{}));
    };
    const Pose before = poseAt(scene, 0.0);
    const std::set<std::uint64_t> keys = keysOf(before, request);
    ASSERT_EQ(keys.size(), 2u);

    FrameRequest elsewhere = request;
    elsewhere.camera.position = glm::dvec3(2, 3, 7);
    elsewhere.width = 320;
    EXPECT_EQ(keysOf(before, elsewhere), keys) << "who looks does not matter";
    elsewhere = request;
    elsewhere.exposure = 2.0;
    elsewhere.toneMap = ToneMap::aces;
    EXPECT_EQ(keysOf(before, elsewhere), keys) << "nor how it is displayed";

    Pose moved = before;
    moved.worldFromNode[2] = at(0, 0.1, -3) * glm::dmat4(1.0);  // the box
    const std::set<std::uint64_t> after = keysOf(moved, request);
    for (const std::uint64_t key : after) {
        EXPECT_FALSE(keys.contains(key)) << "both balls see the box, wherever it goes";
    }
}

TEST(ViewTree, EveryKnobThatChangesACubesTexelsChangesItsKey) {
    const Scene scene = ballScene();
    const FrameRequest plain = forced(lookingFrom({0, 1, 6}));
    const auto changed = [&](auto&& change) {
        FrameRequest request = plain;
        change(request);
        const std::set<std::uint64_t> before = probeKeys(planOf(scene, plain));
        for (const std::uint64_t key : probeKeys(planOf(scene, request))) {
            if (before.contains(key)) return false;
        }
        return true;
    };
    EXPECT_TRUE(changed([](FrameRequest& r) { r.accuracy.probeSize = 64; }));
    EXPECT_TRUE(changed([](FrameRequest& r) { r.accuracy.probeSamples = 5; }));
    EXPECT_TRUE(changed([](FrameRequest& r) { r.accuracy.environmentSize = 32; }));
    EXPECT_TRUE(changed([](FrameRequest& r) { r.environment.intensity = 0.5; }));
    EXPECT_TRUE(changed([](FrameRequest& r) {
        r.environment.rotation = {0, std::sqrt(0.5), 0, std::sqrt(0.5)};
    }));
    EXPECT_TRUE(changed([](FrameRequest& r) { r.environment.visible = false; }));
    EXPECT_TRUE(changed([](FrameRequest& r) {
        MaterialOverride red;
        red.material = "grey";
        red.baseColor = glm::dvec3(1, 0, 0);
        r.overrides = {red};
    }));
}

// A cube sees all around it, to infinity: nothing but its owner is ever out of its sight.
TEST(ViewTree, ACubeBelongsToThePlaceItIsSeenFrom) {
    Scene scene;
    placeAt(scene, addBallMesh(scene, "ball", addMaterial(scene, mirror())), at(0, 0, 0), "ball");
    placeAt(scene, addBoxMesh(scene, "box", addMaterial(scene, dullGrey())), at(0, 0, -3), "box");
    updateContentHash(scene);
    FrameRequest request = forced(lookingFrom({0, 1, 6}));
    const auto keysAt = [&](const glm::dmat4& worldFromBall) {
        Pose pose = poseAt(scene, 0.0);
        pose.worldFromNode[0] = worldFromBall;
        return probeKeys(planFrame(scene, pose, request, plainMap(), {}, DeviceLimits{}));
    };
    EXPECT_EQ(keysAt(at(0, 0, 0)), keysAt(at(0, 0, 0)));
    EXPECT_NE(keysAt(at(0, 0, 0)), keysAt(at(0, 0, 0.01)));
}

TEST(ViewTree, ACurvedMirrorOutOfViewOrSwitchedOffIsNotCaptured) {
    const FramePlan away = planOf(ballScene(), forced(lookingFrom({0, 1, 6}, {0, 1, 9})));
    EXPECT_EQ(effectPasses(away), 0u);
    EXPECT_THAT(away.skipped, skippedAs("probes", "no curved mirror in view"));
    const FramePlan far = planOf(ballScene(), forced(lookingFrom({0, 1, 2000})));
    EXPECT_EQ(effectPasses(far), 0u);
    EXPECT_THAT(far.skipped, skippedAs("probe:left", "smaller than a pixel"));
    FrameRequest off = forced(lookingFrom({0, 1, 6}));
    off.effects.environmentReflection = false;
    const FramePlan plan = planOf(ballScene(), off);
    EXPECT_EQ(effectPasses(plan), 0u);
    EXPECT_THAT(plan.skipped, skippedAs("probes", "switched off"));
}

TEST(ViewTree, TheOrderOfInstancesInTheFileDecidesNothing) {
    const auto scene = [](std::vector<int> order) {
        Scene s;
        const Index ball = addBallMesh(s, "ball", addMaterial(s, mirror()));
        const Index square = addSquareMesh(s, "square", addMaterial(s, mirror()));
        const Index pane = addSquareMesh(s, "pane", addMaterial(s, clearGlass()));
        const Index box = addBoxMesh(s, "box", addMaterial(s, dullGrey()));
        for (const int i : order) {
            if (i == 0) placeAt(s, ball, at(-1.5, 0, 0), "left");
            if (i == 1) placeAt(s, ball, at(1.5, 0, 0), "right");
            if (i == 2) placeAt(s, square, at(0, 0, -3), "mirror");
            if (i == 3) placeAt(s, pane, at(0, 0, 2), "pane");
            if (i == 4) placeAt(s, box, at(0, 3, 0), "box");
        }
        return s;
    };
    const FrameRequest request = forced(lookingFrom({0, 1, 7}));
    // Draws by name, since their numbers follow the file; passes may come in another order.
    const auto contentOf = [&](const Scene& s) {
        std::multiset<std::string> content;
        const FramePlan plan = planOf(s, request);
        for (const Pass& pass : plan.passes) {
            std::string line = std::string(nameOf(pass.kind)) + ' ' +
                               std::to_string(pass.generation) + ' ' + std::to_string(pass.face) +
                               ' ' + std::to_string(plan.targets[pass.target].width);
            std::multiset<std::string> drawn;
            for (const auto* draws : {&pass.depthDraws, &pass.opaqueDraws, &pass.blendedDraws}) {
                for (const Draw& d : *draws) {
                    drawn.insert(s.nodes[s.instances[d.instance].node].name + '/' +
                                 std::to_string(d.features) + '/' + std::to_string(d.firstIndex) +
                                 '/' + std::to_string(d.indexCount));
                }
            }
            if (pass.kind != PassKind::capture) line += ' ' + pass.name;
            for (const std::string& d : drawn) line += ' ' + d;
            content.insert(line);
        }
        return content;
    };
    const auto expected = contentOf(scene({0, 1, 2, 3, 4}));
    for (std::vector<int> order : {std::vector{4, 3, 2, 1, 0}, {2, 0, 4, 1, 3}, {1, 0, 3, 4, 2}}) {
        EXPECT_EQ(contentOf(scene(order)), expected);
    }
}

// ---- glass -------------------------------------------------------------------------------------

Scene paneScene(std::vector<glm::dmat4> places, float roughness = 0.0f) {
    Scene scene;
    Material glass = clearGlass(roughness);
    glass.reflection = Reflection::none;  // what is counted here is glass
    const Index pane = addSquareMesh(scene, "pane", addMaterial(scene, glass));
    for (const glm::dmat4& m : places) placeAt(scene, pane, m, "pane");
    placeAt(scene, addBoxMesh(scene, "box", addMaterial(scene, dullGrey())), at(0, 0, -6), "box");
    return scene;
}

TEST(ViewTree, PanesInARowHaveABackdropEach) {
    for (std::size_t panes = 1; panes <= 4; ++panes) {
        std::vector<glm::dmat4> places;
        for (std::size_t i = 0; i < panes; ++i) places.push_back(at(0, 0, -double(i)));
        const FramePlan plan = planOf(paneScene(places), forced(lookingFrom({0, 0, 5})));
        const std::vector<Pass> glass = passesOf(plan, PassKind::glass);
        ASSERT_EQ(glass.size(), panes) << toText(plan);
        EXPECT_EQ(count(plan, PassKind::backdrop), panes);
        for (std::size_t i = 0; i < panes; ++i) {
            ASSERT_EQ(glass[i].opaqueDraws.size(), 1u);
            EXPECT_EQ(glass[i].opaqueDraws[0].instance, panes - 1 - i) << "far to near";
        }
    }
}

TEST(ViewTree, PanesSideBySideShareABackdrop) {
    const FramePlan plan = planOf(paneScene({at(-1.5, 0, 0), at(1.5, 0, 0), at(0, 2.5, 0.1)}),
                                  forced(lookingFrom({0, 0, 6})));
    EXPECT_EQ(count(plan, PassKind::backdrop), 1u) << toText(plan);
    ASSERT_EQ(count(plan, PassKind::glass), 1u);
    EXPECT_EQ(passesOf(plan, PassKind::glass)[0].opaqueDraws.size(), 3u);
}

TEST(ViewTree, SixPanesInARowShareTheNearestLayerAndNoneIsLost) {
    std::vector<glm::dmat4> places;
    for (int i = 0; i < 6; ++i) places.push_back(at(0, 0, -0.5 * i));
    const FramePlan plan = planOf(paneScene(places), forced(lookingFrom({0, 0, 5})));
    std::multiset<std::uint32_t> drawn;
    for (const Pass& pass : passesOf(plan, PassKind::glass)) {
        for (const Draw& d : pass.opaqueDraws) drawn.insert(d.instance);
    }
    EXPECT_THAT(drawn, ElementsAre(0u, 1u, 2u, 3u, 4u, 5u));
    EXPECT_EQ(count(plan, PassKind::glass), 4u);
}

TEST(ViewTree, PanesAroundTheEyesHeightAreOrderedByTheirMiddles) {
    // At an angle, so that the eye is in the box of either.
    const auto turned = [](double z) {
        return glm::scale(glm::rotate(at(0, 0, z), glm::radians(60.0), glm::dvec3(0, 1, 0)),
                          glm::dvec3(5.0));
    };
    for (const bool nearFirst : {true, false}) {
        const FramePlan plan = planOf(
            nearFirst ? paneScene({turned(0), turned(-0.5)}) : paneScene({turned(-0.5), turned(0)}),
            forced(lookingFrom({0, 0, 2})));
        const std::vector<Pass> glass = passesOf(plan, PassKind::glass);
        ASSERT_EQ(glass.size(), 2u) << toText(plan);
        EXPECT_EQ(glass[0].opaqueDraws.at(0).instance, nearFirst ? 1u : 0u) << "the far one";
    }
}

TEST(ViewTree, TheSidesOfAGlassBodyShareABackdropWithoutIt) {
    Scene scene;
    Material body = clearGlass();
    body.thickness = 1.0f;
    body.reflection = Reflection::none;
    place(scene, addBoxMesh(scene, "block", addMaterial(scene, body)), {0, 0, 0});
    for (const glm::dvec3& eye : {glm::dvec3(3, 4, 5), glm::dvec3(0, 0, 0)}) {
        const FramePlan plan = planOf(scene, forced(lookingFrom(eye, eye - glm::dvec3(3, 4, 5))));
        ASSERT_EQ(count(plan, PassKind::glass), 1u) << toText(plan);
        for (const Draw& draw : passesOf(plan, PassKind::glass)[0].opaqueDraws) {
            // An eye within sees the sides from their backs.
            EXPECT_EQ((draw.features & FEATURE_DOUBLE_SIDED) != 0, eye == glm::dvec3(0, 0, 0));
        }
    }
}

TEST(ViewTree, BlendedSurfacesAreDrawnBetweenTheGlassBehindAndInFrontOfThem) {
    Scene scene = paneScene({at(0, 0, 0), at(0, 0, -2)});
    Material veil = dullGrey();
    veil.alphaMode = AlphaMode::blend;
    const Index square = addSquareMesh(scene, "veil", addMaterial(scene, veil));
    const Index behind = placeAt(scene, square, at(0, 0, -3), "behind");
    const Index between = placeAt(scene, square, at(0, 0, -1), "between");
    const Index before = placeAt(scene, square, at(0, 0, 1), "before");
    const FramePlan plan = planOf(scene, forced(lookingFrom({0, 0, 5})));
    const auto only = [](Index instance) { return ElementsAre(Field(&Draw::instance, instance)); };
    EXPECT_THAT(rootOf(plan).blendedDraws, only(behind));
    const std::vector<Pass> glass = passesOf(plan, PassKind::glass);
    ASSERT_EQ(glass.size(), 2u);
    EXPECT_THAT(glass[0].blendedDraws, only(between));
    EXPECT_THAT(glass[1].blendedDraws, only(before));
}

TEST(ViewTree, OnlyRoughGlassHasABlurredBackdrop) {
    const auto levels = [](float roughness) {
        const FramePlan plan =
            planOf(paneScene({at(0, 0, 0)}, roughness), forced(lookingFrom({0, 0, 5})));
        return plan.targets[passesOf(plan, PassKind::backdrop).at(0).target].levels;
    };
    EXPECT_EQ(levels(0.0f), 1u);
    EXPECT_GT(levels(0.4f), 1u);
}

TEST(ViewTree, WithRefractionOffTheDrawsAreThoseOfASceneWithoutTransmission) {
    FrameRequest request = forced(lookingFrom({0, 0, 5}));
    request.effects.refraction = false;
    Scene glass = paneScene({at(0, 0, 0), at(1, 0, -2)});
    Scene without = glass;
    for (Material& m : without.materials) m.transmission = 0.0f;
    const FramePlan plan = planOf(glass, request);
    EXPECT_EQ(effectPasses(plan), 0u);
    EXPECT_THAT(plan.skipped, skippedAs("glass", "switched off"));
    EXPECT_EQ(rootOf(plan), rootOf(planOf(without, request)));
}

// ---- decisions ---------------------------------------------------------------------------------

TEST(ViewTree, WhatTheRequestAsksForIsTakenAndEveryDecisionListsItsCandidates) {
    Scene scene = mirrorScene();
    placeAt(scene, addBallMesh(scene, "ball", addMaterial(scene, mirror())), at(0, 0, 3), "ball");
    placeAt(scene, addSquareMesh(scene, "pane", addMaterial(scene, clearGlass())), at(0, 0, 4),
            "pane");
    FrameRequest request = lookingFrom({0, 0, 9});
    const auto takenBy = [&](const std::string& start) {
        const FramePlan plan = planOf(scene, request);
        std::set<Method> taken;
        for (const Decision& d : plan.decisions) {
            EXPECT_GE(d.candidates.size(), 2u) << d.name;
            EXPECT_FALSE(d.reason.empty()) << d.name;
            EXPECT_THAT(d.candidates, Contains(Field(&Candidate::method, d.taken)));
            for (const Candidate& c : d.candidates) {
                EXPECT_GE(c.milliseconds, 0.0);
                EXPECT_GT(c.error, 0.0);
            }
            if (d.name.starts_with(start)) taken.insert(d.taken);
        }
        return taken;
    };
    for (const auto& [asked, method] : {std::pair(PlanarMethod::environment, Method::environment),
                                        {PlanarMethod::mirror, Method::mirror}}) {
        request.accuracy.planar = asked;
        EXPECT_THAT(takenBy("mirror:"), ElementsAre(method));
    }
    for (const auto& [asked, method] : {std::pair(CurvedMethod::environment, Method::environment),
                                        {CurvedMethod::probe, Method::probe}}) {
        request.accuracy.curved = asked;
        EXPECT_THAT(takenBy("probe:"), ElementsAre(method));
    }
    for (const auto& [asked, method] : {std::pair(GlassMethod::environment, Method::environment),
                                        {GlassMethod::backdrop, Method::backdrop}}) {
        request.accuracy.glass = asked;
        EXPECT_THAT(takenBy("glass:"), ElementsAre(method));
    }
}

TEST(ViewTree, LeftToItselfAStricterPresetNeverTakesAWorseWay) {
    const auto errors = [](Preset preset) {
        Scene scene = mirrorScene();
        placeAt(scene, addBallMesh(scene, "ball", addMaterial(scene, mirror())), at(0, 0, 3));
        FrameRequest request = lookingFrom({0, 0, 9});
        request.accuracy = accuracyOf(preset);
        std::map<std::string, double> result;
        for (const Decision& d : planOf(scene, request).decisions) {
            for (const Candidate& c : d.candidates) {
                if (c.method == d.taken) result[d.name] = c.error;
            }
        }
        return result;
    };
    const auto draft = errors(Preset::draft), standard = errors(Preset::standard),
               fine = errors(Preset::fine);
    ASSERT_EQ(fine.size(), 2u);
    for (const auto& [name, error] : fine) {
        EXPECT_LE(error, standard.at(name)) << name;
        EXPECT_LE(standard.at(name), draft.at(name)) << name;
    }
}

TEST(ViewTree, EqualRequestsGiveEqualPlansWhateverIsInThem) {
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
