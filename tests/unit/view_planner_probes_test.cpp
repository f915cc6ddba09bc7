// Passes of curved mirrors: captured cubes, their keys, their generations.
#include "plan/graph/features.h"
#include "view_planner_support.h"

#include <set>

namespace clerestory::test {
namespace {

TEST(ViewPlanner, TwoCurvedMirrorsAndTwoGenerationsAre24FaceViewsTheFirstGenerationFirst) {
    const FramePlan plan = planOf(ballScene(), forced(lookingFrom({0, 1, 6})));
    const std::vector<Pass> faces = passesOf(plan, "capture");
    ASSERT_EQ(faces.size(), 24u) << toText(plan);
    EXPECT_EQ(count(plan, "prefilter"), 4u);
    // Passes that show a cube come after it, and a first generation shows none.
    std::set<TargetId> finished;
    for (const Pass& pass : plan.passes) {
        if (pass.kind() == "prefilter") finished.insert(pass.target);
        if (pass.kind() != "capture") continue;
        const auto& face = std::get<DrawScene>(pass.work);
        if (pass.generation == 1) {
            EXPECT_TRUE(face.reflections.empty()) << toText(plan);
        }
        for (const ReflectedPicture& r : face.reflections) {
            EXPECT_TRUE(finished.contains(r.target)) << pass.name << " reads what is not drawn";
        }
    }
}

TEST(ViewPlanner, EveryPassOfACubeNamesItsOwner) {
    const FramePlan plan = planOf(ballScene(), forced(lookingFrom({0, 1, 6})));
    for (const char* kind : {"capture", "levels", "prefilter"}) {
        for (const Pass& pass : passesOf(plan, kind)) {
            EXPECT_EQ(pass.subject.kind, Subject::Kind::probe) << pass.name;
            EXPECT_TRUE(pass.subject.name == "left" || pass.subject.name == "right") << pass.name;
        }
    }
    EXPECT_EQ(passesOf(plan, "surface").at(0).subject, Subject{}) << "the view as a whole";
}

TEST(ViewPlanner, ResidentCubesAreNotRedrawnForOtherViews) {
    const Scene scene = ballScene();
    const FramePlan first = planOf(scene, forced(lookingFrom({0, 1, 6})));
    const FramePlan second = planOf(scene, forced(lookingFrom({1, 2, 5})), allOf(first));
    EXPECT_EQ(count(second, "capture"), 0u) << toText(second);
    EXPECT_EQ(count(second, "prefilter"), 0u);
    EXPECT_EQ(count(second, "levels"), 0u);
    EXPECT_EQ(count(second, "environment"), 0u);
    EXPECT_THAT(second.skipped, skippedAs("probe:left", "resident and unchanged"));
    const Subject left{Subject::Kind::probe, "left"};
    EXPECT_THAT(second.skipped, testing::Contains(testing::Field(&Skipped::subject, left)));
    EXPECT_EQ(rootOf(second).reflections.size(), 2u) << "still read";
    for (const std::uint64_t key : probeKeys(second)) {
        EXPECT_TRUE(allOf(first).keys.contains(key));
    }
}

TEST(ViewPlanner, RoughSurfacesAreLookedUpSeveralTimesOnRequest) {
    Scene scene;
    const auto ball = [&](const char* name, Material material, double x) {
        placeAt(scene, addBallMesh(scene, name, addMaterial(scene, std::move(material))),
                at(x, 0, 0), name);
    };
    ball("smooth", mirror(0.1f), -3.0);
    ball("rough", mirror(0.4f), -1.0);
    ball("rougher", mirror(0.9f), 1.0);
    ball("dull", dullGrey(), 3.0);
    updateContentHash(scene);
    FrameRequest r = forced(lookingFrom({0, 1, 8}));
    const auto sampledIn = [&](const FramePlan& plan) {
        std::set<std::string> names;
        for (const Pass& pass : plan.passes) {
            const auto* drawn = std::get_if<DrawScene>(&pass.work);
            for (const Draw& draw : drawn ? drawn->opaqueDraws : std::vector<Draw>{}) {
                if (!(draw.features & FEATURE_MAP_SAMPLES)) continue;
                names.insert(std::string(pass.kind()) + " " +
                             scene.nodes[scene.instances[draw.instance].node].name);
            }
        }
        return names;
    };
    r.accuracy.curvedSamples = 1;
    EXPECT_TRUE(sampledIn(planOf(scene, r)).empty());
    const auto keys = probeKeys(planOf(scene, r));
    r.accuracy.curvedSamples = 16;
    EXPECT_EQ(sampledIn(planOf(scene, r)),
              (std::set<std::string>{"surface rough", "surface rougher"}));
    EXPECT_EQ(probeKeys(planOf(scene, r)), keys) << "captured faces are unchanged";
}

TEST(ViewPlanner, CubeKeysHashTheirContent) {
    const Scene scene = ballScene();
    FrameRequest request = forced(lookingFrom({0, 1, 6}));
    request.accuracy.generations = 1;
    const auto keysOf = [&](const Pose& pose, const FrameRequest& r) {
        return probeKeys(planOf(scene, pose, r));
    };
    const Pose before = poseAt(scene, 0.0);
    const std::set<std::uint64_t> keys = keysOf(before, request);
    ASSERT_EQ(keys.size(), 2u);

    FrameRequest elsewhere = request;
    elsewhere.camera.position = glm::dvec3(2, 3, 7);
    elsewhere.width = 320;
    EXPECT_EQ(keysOf(before, elsewhere), keys) << "independent of the viewer";
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

TEST(ViewPlanner, EveryKnobThatChangesACubesTexelsChangesItsKey) {
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

// A cube shows all directions up to infinity, and everything except its owner.
TEST(ViewPlanner, CubesDependOnTheirCapturePoint) {
    Scene scene;
    placeAt(scene, addBallMesh(scene, "ball", addMaterial(scene, mirror())), at(0, 0, 0), "ball");
    placeAt(scene, addBoxMesh(scene, "box", addMaterial(scene, dullGrey())), at(0, 0, -3), "box");
    updateContentHash(scene);
    FrameRequest request = forced(lookingFrom({0, 1, 6}));
    const auto keysAt = [&](const glm::dmat4& worldFromBall) {
        Pose pose = poseAt(scene, 0.0);
        pose.worldFromNode[0] = worldFromBall;
        return probeKeys(planOf(scene, pose, request));
    };
    EXPECT_EQ(keysAt(at(0, 0, 0)), keysAt(at(0, 0, 0)));
    EXPECT_NE(keysAt(at(0, 0, 0)), keysAt(at(0, 0, 0.01)));
}

TEST(ViewPlanner, ACurvedMirrorOutOfViewOrSwitchedOffIsNotCaptured) {
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

TEST(ViewPlanner, InstanceOrderDoesNotMatter) {
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
    const auto faceOf = [](const Pass& pass) {
        const auto* drawn = std::get_if<DrawScene>(&pass.work);
        return std::to_string(drawn ? drawn->face : 0);
    };
    const auto contentOf = [&](const Scene& s) {
        std::multiset<std::string> content;
        const FramePlan plan = planOf(s, request);
        for (const Pass& pass : plan.passes) {
            std::string line = std::string(pass.kind()) + ' ' + std::to_string(pass.generation) +
                               ' ' + faceOf(pass) + ' ' +
                               std::to_string(plan.targets[pass.target].width);
            std::multiset<std::string> drawn;
            for (const std::span<const Draw> draws : pass.drawLists()) {
                for (const Draw& d : draws) {
                    drawn.insert(s.nodes[s.instances[d.instance].node].name + '/' +
                                 std::to_string(d.features) + '/' + std::to_string(d.firstIndex) +
                                 '/' + std::to_string(d.indexCount));
                }
            }
            if (pass.kind() != "capture") line += ' ' + pass.name;
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

}  // namespace
}  // namespace clerestory::test
