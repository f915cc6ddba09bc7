// Which technique is chosen for a mirror or a piece of glass, and what it is predicted to cost.
#include "plan/cost/cost.h"
#include "view_planner_support.h"

#include "plan/graph/work.h"

#include <map>

namespace clerestory::test {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::Field;

TEST(ViewPlanner, RequestedTechniquesAreUsedAndCandidatesListed) {
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
    for (const auto& [requested, method] :
         {std::pair(PlanarMethod::environment, Method::environment),
          {PlanarMethod::mirror, Method::mirror}}) {
        request.accuracy.planar = requested;
        EXPECT_THAT(takenBy("mirror:"), ElementsAre(method));
    }
    for (const auto& [requested, method] :
         {std::pair(CurvedMethod::environment, Method::environment),
          {CurvedMethod::probe, Method::probe}}) {
        request.accuracy.curved = requested;
        EXPECT_THAT(takenBy("probe:"), ElementsAre(method));
    }
    for (const auto& [requested, method] :
         {std::pair(GlassMethod::environment, Method::environment),
          {GlassMethod::backdrop, Method::backdrop}}) {
        request.accuracy.glass = requested;
        EXPECT_THAT(takenBy("glass:"), ElementsAre(method));
    }
}

// The predicted cost of a technique is compared with the passes that it causes.
TEST(ViewPlanner, CostsMatchTheResultingWork) {
    Scene scene = mirrorScene();
    placeAt(scene, addBallMesh(scene, "ball", addMaterial(scene, mirror())), at(0, 0, 3), "ball");
    // Behind the eye, so that the whole mirror shows surfaces.
    const Index wall = addBoxMesh(scene, "wall", addMaterial(scene, dullGrey()));
    for (const double z : {20.0, 40.0}) place(scene, wall, {0, 0, z}, 9.0);
    updateContentHash(scene);
    FrameRequest request = forced(lookingFrom({0, 0, 9}));
    request.accuracy.generations = 1;
    const FramePlan plan = planOf(scene, request);
    constexpr double kFramesOfACapture = 16.0;  // that share its price
    int mirrors = 0, probes = 0;
    for (const Decision& d : plan.decisions) {
        const auto taken = std::find_if(d.candidates.begin(), d.candidates.end(),
                                        [&](const Candidate& c) { return c.method == d.taken; });
        Work work{.software = DeviceLimits{}.software};
        for (const Pass& pass : plan.passes) {
            if (pass.kind() == "prefilter" && pass.subject == d.subject) {
                work.mapSamples += static_cast<double>(shadedSamples(plan, pass));
            }
            const bool relevant = pass.kind() == "mirror" || pass.kind() == "capture";
            if (!relevant || pass.name != d.name || pass.generation != 1) continue;
            const TargetSpec& target = plan.targets[pass.target];
            work.draws += static_cast<double>(totals(pass).draws);
            work.triangles += static_cast<double>(totals(pass).triangles);
            work.pixels += double(target.width) * target.height;
            work.views += 1.0;
        }
        ASSERT_GT(work.views, 0.0) << d.name << "\n" << toText(plan);
        if (d.taken == Method::mirror) {
            ++mirrors;
            EXPECT_NEAR(taken->milliseconds, milliseconds(work), 0.05 * milliseconds(work));
        } else {
            ++probes;
            work.frames = kFramesOfACapture;
            EXPECT_GE(taken->milliseconds, milliseconds(work));  // what culling saves is not known
            EXPECT_LE(taken->milliseconds, 2.0 * milliseconds(work));
        }
    }
    EXPECT_EQ(mirrors, 1);
    EXPECT_EQ(probes, 1);
}

// What a mirror shows of the sky is not shaded.
TEST(ViewPlanner, AMirrorOfTheSkyCostsLessThanOneOfAWall) {
    const auto cost = [](double wall) {
        Scene scene = mirrorScene();
        const Index box = addBoxMesh(scene, "wall", addMaterial(scene, dullGrey()));
        place(scene, box, {0, 0, 12}, wall);
        updateContentHash(scene);
        FrameRequest request = forced(lookingFrom({0, 0, 5}));
        request.width = 1280;
        request.height = 720;
        const FramePlan plan = planOf(scene, request);
        for (const Decision& d : plan.decisions) {
            for (const Candidate& c : d.candidates) {
                if (c.method == Method::mirror) return c.milliseconds;
            }
        }
        return 0.0;
    };
    const double sky = cost(0.1), wall = cost(6.0);
    EXPECT_GT(sky, 0.0);
    EXPECT_GT(wall, 1.5 * sky);
    EXPECT_LT(wall, 6.0 * sky);
}

TEST(ViewPlanner, TheCheapestOfAboutEqualErrorsIsTakenWhereNoneIsEnough) {
    const auto taken = [](double mirrorError, double tracedError, double tolerance) {
        const Candidate candidates[] = {{Method::environment, 0.0, 5.0},
                                        {Method::mirror, 30.0, mirrorError},
                                        {Method::traced, 10.0, tracedError}};
        return candidates[cheapest(candidates, tolerance)].method;
    };
    EXPECT_EQ(taken(0.19, 0.20, 0.08), Method::traced) << "five per cent are no difference";
    EXPECT_EQ(taken(0.10, 0.20, 0.08), Method::mirror);
    EXPECT_EQ(taken(0.10, 0.20, 0.30), Method::traced) << "both are enough";
    EXPECT_EQ(taken(0.10, 0.20, 5.0), Method::environment);
}

// A mirror of a thousandth of the picture in a closed room: the sky in it would be the largest
// error of the frame.
TEST(ViewPlanner, SmallMirrorsIndoorsDoNotShowTheSky) {
    Scene scene;
    const Index wall = addMaterial(scene, Material{.metallic = 0.0f});
    placeAt(scene, addSquareMesh(scene, "mirror", addMaterial(scene, mirror())), at(0, 0, 0),
            "mirror");
    for (const glm::dvec3& side : {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)}) {
        for (const double sign : {-1.0, 1.0}) {
            const Index mesh = addBallMesh(scene, "wall", wall);
            placeAt(scene, mesh,
                    glm::translate(glm::dmat4(1.0), 100.0 * sign * side) *
                        glm::scale(glm::dmat4(1.0), glm::dvec3(62.0)),
                    "wall");
        }
    }
    FrameRequest request = lookingFrom({0, 0, 44});
    const auto methodOfMirror = [&](Preset preset) {
        request.accuracy = accuracyOf(preset);
        for (const Decision& d : planOf(scene, request).decisions) {
            if (d.effect == Effect::planarReflection) {
                EXPECT_LT(d.share, 0.0012);
                return d.taken;
            }
        }
        return Method::unshadowed;
    };
    EXPECT_NE(methodOfMirror(Preset::standard), Method::environment);
    EXPECT_EQ(methodOfMirror(Preset::draft), Method::environment);
}

TEST(ViewPlanner, StricterPresetsNeverChooseAWorseTechnique) {
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

}  // namespace
}  // namespace clerestory::test
