// Passes of glass: layers, backdrops, bodies, and blended surfaces between them.
#include "view_planner_support.h"

#include "plan/graph/features.h"
#include "scene/builtin/modelling.h"

#include <set>

namespace clerestory::test {
namespace {

using testing::ElementsAre;
using testing::Field;

Scene paneScene(std::vector<glm::dmat4> places, float roughness = 0.0f) {
    Scene scene;
    Material glass = clearGlass(roughness);
    glass.reflection = Reflection::none;  // what is counted here is glass
    const Index pane = addSquareMesh(scene, "pane", addMaterial(scene, glass));
    for (const glm::dmat4& m : places) placeAt(scene, pane, m, "pane");
    placeAt(scene, addBoxMesh(scene, "box", addMaterial(scene, dullGrey())), at(0, 0, -6), "box");
    return scene;
}

TEST(ViewPlanner, PanesInARowHaveABackdropEach) {
    for (std::size_t panes = 1; panes <= 4; ++panes) {
        std::vector<glm::dmat4> places;
        for (std::size_t i = 0; i < panes; ++i) places.push_back(at(0, 0, -double(i)));
        const FramePlan plan = planOf(paneScene(places), forced(lookingFrom({0, 0, 5})));
        const std::vector<DrawGlass> glass = worksOf<DrawGlass>(plan);
        ASSERT_EQ(glass.size(), panes) << toText(plan);
        EXPECT_EQ(count(plan, "backdrop"), panes);
        for (std::size_t i = 0; i < panes; ++i) {
            ASSERT_EQ(glass[i].glassDraws.size(), 1u);
            EXPECT_EQ(glass[i].glassDraws[0].instance, panes - 1 - i) << "far to near";
        }
    }
}

// A thin ball and a flat pane, in a closed room or in the open.
FramePlan planOfThinGlass(bool flat, bool indoors) {
    Scene scene;
    const Index glass = addMaterial(scene, clearGlass());
    placeAt(scene, flat ? addSquareMesh(scene, "pane", glass) : addBallMesh(scene, "pane", glass),
            at(0, 0, 0), "pane");
    const Index wall = addBoxMesh(scene, "wall", addMaterial(scene, dullGrey()));
    for (int axis = 0; indoors && axis < 3; ++axis) {
        for (const double side : {-6.0, 6.0}) {
            glm::dvec3 center(0.0), size(6.0);
            center[axis] = side;
            size[axis] = 0.1;
            placeAt(scene, wall, glm::scale(glm::translate(glm::dmat4(1.0), center), size), "wall");
        }
    }
    updateContentHash(scene);
    return planOnProcessor(scene, lookingFrom({0, 0, 5}));
}

// Its reflection of the room is what is seen of it; a flat pane has a mirrored view.
TEST(ViewPlanner, CurvedPanesIndoorsFollowRays) {
    const auto method = [](const FramePlan& plan) {
        for (const Decision& choice : plan.decisions) {
            if (choice.effect == Effect::refraction) return choice.taken;
        }
        return Method::environment;
    };
    EXPECT_EQ(method(planOfThinGlass(false, true)), Method::traced);
    EXPECT_EQ(method(planOfThinGlass(false, false)), Method::backdrop);
    EXPECT_EQ(method(planOfThinGlass(true, true)), Method::backdrop);
}

TEST(ViewPlanner, PanesSideBySideShareABackdrop) {
    const FramePlan plan = planOf(paneScene({at(-1.5, 0, 0), at(1.5, 0, 0), at(0, 2.5, 0.1)}),
                                  forced(lookingFrom({0, 0, 6})));
    EXPECT_EQ(count(plan, "backdrop"), 1u) << toText(plan);
    ASSERT_EQ(count(plan, "glass"), 1u);
    EXPECT_EQ(worksOf<DrawGlass>(plan)[0].glassDraws.size(), 3u);
}

TEST(ViewPlanner, SixPanesInARowShareTheNearestLayer) {
    std::vector<glm::dmat4> places;
    for (int i = 0; i < 6; ++i) places.push_back(at(0, 0, -0.5 * i));
    const FramePlan plan = planOf(paneScene(places), forced(lookingFrom({0, 0, 5})));
    std::multiset<std::uint32_t> drawn;
    for (const DrawGlass& pass : worksOf<DrawGlass>(plan)) {
        for (const Draw& d : pass.glassDraws) drawn.insert(d.instance);
    }
    EXPECT_THAT(drawn, ElementsAre(0u, 1u, 2u, 3u, 4u, 5u));
    EXPECT_EQ(count(plan, "glass"), 4u);
}

TEST(ViewPlanner, PanesAtEyeHeightAreOrderedByTheirCentres) {
    // At an angle, so that the eye is inside both boxes.
    const auto turned = [](double z) {
        return glm::scale(glm::rotate(at(0, 0, z), glm::radians(60.0), glm::dvec3(0, 1, 0)),
                          glm::dvec3(5.0));
    };
    for (const bool nearFirst : {true, false}) {
        const FramePlan plan = planOf(
            nearFirst ? paneScene({turned(0), turned(-0.5)}) : paneScene({turned(-0.5), turned(0)}),
            forced(lookingFrom({0, 0, 2})));
        const std::vector<DrawGlass> glass = worksOf<DrawGlass>(plan);
        ASSERT_EQ(glass.size(), 2u) << toText(plan);
        EXPECT_EQ(glass[0].glassDraws.at(0).instance, nearFirst ? 1u : 0u) << "the far one";
    }
}

// The windscreen and the rear window of a car are one mesh; one is visible through the other.
TEST(ViewPlanner, PanesOfOneMeshBehindEachOtherHaveABackdropEach) {
    for (const float roughness : {0.0f, 0.4f}) {
        Scene scene;
        Material glass = clearGlass(roughness);
        glass.reflection = Reflection::none;
        MeshDraft panes = shapes::draft("panes", addMaterial(scene, glass));
        for (const float z : {0.0f, -8.0f}) shapes::addSphere(panes, {0.0f, 0.0f, z}, 1.0f, 40);
        placeAt(scene, addMesh(scene, std::move(panes)), at(0, 0, 0), "panes");
        const FramePlan plan = planOf(scene, forced(lookingFrom({0, 0, 5})));
        const std::vector<DrawGlass> drawn = worksOf<DrawGlass>(plan);
        if (roughness > 0.0f) {
            EXPECT_EQ(drawn.size(), 1u) << toText(plan);
            continue;
        }
        ASSERT_GE(drawn.size(), 2u) << toText(plan);
        const auto farthest = [&](const DrawGlass& pass) {
            float z = 0.0f;
            for (const Draw& d : pass.glassDraws) {
                for (std::uint32_t i = d.firstIndex; i < d.firstIndex + d.indexCount; ++i) {
                    z = std::min(z, scene.vertices[scene.indices[i]].position.z);
                }
            }
            return z;
        };
        EXPECT_LT(farthest(drawn.front()), -7.0f);
        EXPECT_GT(farthest(drawn.back()), -2.0f);
    }
}

// The far walls of shells, then their near ones; shells that hardly overlap share both layers.
TEST(ViewPlanner, ShellsHaveABackdropForEachWall) {
    for (const float roughness : {0.0f, 0.4f}) {
        for (const int side : {1, 4}) {
            Scene scene;
            Material glass = clearGlass(roughness);
            glass.reflection = Reflection::none;
            glass.doubleSided = true;
            MeshDraft ball = shapes::draft("ball", addMaterial(scene, glass));
            shapes::addSphere(ball, glm::vec3(0.0f), 1.0f, 40);
            const Index mesh = addMesh(scene, std::move(ball));
            const glm::dmat4 turned =
                glm::rotate(glm::dmat4(1.0), 0.7, glm::normalize(glm::dvec3(1.0)));
            for (int i = 0; i < side * side; ++i) {
                placeAt(scene, mesh, at(2.8 * (i % side), 2.8 * (i / side), 0.01 * i) * turned,
                        "ball");
            }
            const FramePlan plan =
                planOf(scene, forced(lookingFrom({1.4 * (side - 1), 1.4 * (side - 1), 40.0},
                                                 {1.4 * (side - 1), 1.4 * (side - 1), 0.0})));
            const std::vector<DrawGlass> drawn = worksOf<DrawGlass>(plan);
            ASSERT_EQ(drawn.size(), 2u) << toText(plan);
            for (const DrawnFaces faces : {DrawnFaces::back, DrawnFaces::front}) {
                const DrawGlass& pass = drawn[faces == DrawnFaces::front];
                std::set<std::uint32_t> instances;
                for (const Draw& d : pass.glassDraws) {
                    EXPECT_EQ(d.faces, faces);
                    instances.insert(d.instance);
                }
                EXPECT_EQ(instances.size(), std::size_t(side * side));
            }
        }
    }
}

TEST(ViewPlanner, SidesOfAGlassBodyShareABackdrop) {
    Scene scene;
    Material body = clearGlass();
    body.thickness = 1.0f;
    body.reflection = Reflection::none;
    place(scene, addBoxMesh(scene, "block", addMaterial(scene, body)), {0, 0, 0});
    for (const glm::dvec3& eye : {glm::dvec3(3, 4, 5), glm::dvec3(0, 0, 0)}) {
        const FramePlan plan = planOf(scene, forced(lookingFrom(eye, eye - glm::dvec3(3, 4, 5))));
        ASSERT_EQ(count(plan, "glass"), 1u) << toText(plan);
        const DrawGlass glass = worksOf<DrawGlass>(plan).at(0);
        for (const Draw& draw : glass.glassDraws) {
            // From inside, the eye sees the backs of the sides.
            EXPECT_EQ((draw.features & FEATURE_DOUBLE_SIDED) != 0, eye == glm::dvec3(0, 0, 0));
        }
    }
}

TEST(ViewPlanner, BlendedSurfacesAreDrawnBetweenTheGlassBehindAndInFrontOfThem) {
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
    const std::vector<DrawGlass> glass = worksOf<DrawGlass>(plan);
    ASSERT_EQ(glass.size(), 2u);
    EXPECT_THAT(glass[0].blendedDraws, only(between));
    EXPECT_THAT(glass[1].blendedDraws, only(before));
}

TEST(ViewPlanner, OnlyRoughGlassHasABlurredBackdrop) {
    const auto levels = [](float roughness) {
        const FramePlan plan =
            planOf(paneScene({at(0, 0, 0)}, roughness), forced(lookingFrom({0, 0, 5})));
        return plan.targets[passesOf(plan, "backdrop").at(0).target].levels;
    };
    EXPECT_EQ(levels(0.0f), 1u);
    EXPECT_GT(levels(0.4f), 1u);
}

TEST(ViewPlanner, WithRefractionOffTheDrawsAreThoseOfASceneWithoutTransmission) {
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

}  // namespace
}  // namespace clerestory::test
