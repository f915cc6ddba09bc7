// Where the pictures of lights are in the shadow map, and how large they are.
#include "plan_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

using namespace clerestory;
using namespace clerestory::test;

namespace {

constexpr Preset kPresets[] = {Preset::draft, Preset::standard, Preset::fine};

struct Lit {
    Scene scene = boxScene();
    Lit() { place(scene, scene.instances.front().mesh, {3.0, 0.0, 0.0}); }

    void add(LightKind kind, float strength) {
        const double x = 0.1 * static_cast<double>(scene.lights.size());
        const Index node =
            addNode(scene, "lamp", glm::translate(glm::dmat4(1.0), glm::dvec3(x, 4.0, 0.0)));
        scene.lights.push_back({.name = "lamp",
                                .node = node,
                                .kind = kind,
                                .intensity = glm::vec3(strength),
                                .outerConeAngle = 0.6f});
    }

    FramePlan plan(Preset preset) const {
        FrameRequest request = lookingFrom({0.0, 0.0, 8.0});
        request.effects = {};
        request.accuracy = accuracyOf(preset);
        const Pose pose = poseAt(scene, 0.0);
        EnvironmentMap dark = plainMap();
        dark.meanRadiance = 0.0f;
        return planFrame({.scene = scene,
                          .pose = pose,
                          .environment = dark,
                          .maps = {},
                          .resident = {},
                          .limits = {}},
                         request);
    }
};

TEST(ShadowPlan, PicturesOfWeakLightsHaveHalfTheEdges) {
    Lit lit;
    lit.add(LightKind::point, 100.0f);
    lit.add(LightKind::point, 3.0f);
    for (const Preset preset : kPresets) {
        const FramePlan plan = lit.plan(preset);
        ASSERT_TRUE(plan.lights[0].shadow && plan.lights[1].shadow);
        EXPECT_EQ(plan.lights[0].shadow->tile.width, 2 * plan.lights[1].shadow->tile.width);
    }
    lit.scene.lights[1].intensity = glm::vec3(30.0f);
    const FramePlan plan = lit.plan(Preset::standard);
    EXPECT_EQ(plan.lights[0].shadow->tile.width, plan.lights[1].shadow->tile.width);
}

// Of all lights of a plan, in texels of the map.
std::vector<TargetRect> areasOf(const FramePlan& plan) {
    std::vector<TargetRect> areas;
    for (const PlacedLight& light : plan.lights) {
        if (!light.shadow) continue;
        const bool six = light.shadow->kind == LightShadow::Kind::six;
        TargetRect area = light.shadow->tile;
        area.width *= six ? 3 : 1;
        area.height *= six ? 2 : 1;
        areas.push_back(area);
    }
    return areas;
}

bool overlap(const TargetRect& a, const TargetRect& b) {
    return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height &&
           b.y < a.y + a.height;
}

TEST(ShadowPlan, PicturesFillMostOfTheMapAndDoNotOverlap) {
    const std::vector<std::vector<LightKind>> mixtures = {
        {LightKind::directional},
        {LightKind::directional, LightKind::point},
        {LightKind::spot, LightKind::spot, LightKind::spot, LightKind::point, LightKind::point},
        std::vector<LightKind>(16, LightKind::point),
        std::vector<LightKind>(16, LightKind::directional),
    };
    for (const std::vector<LightKind>& kinds : mixtures) {
        for (const bool weak : {false, true}) {
            Lit lit;
            for (std::size_t i = 0; i < kinds.size(); ++i) {
                lit.add(kinds[i], weak && i > 0 ? 0.5f : 10.0f);
            }
            for (const Preset preset : kPresets) {
                const FramePlan plan = lit.plan(preset);
                const TargetSpec& map = plan.targets.at(plan.shadowMap);
                EXPECT_LE(map.width, 4098u);
                EXPECT_LE(map.height, 4098u);
                const std::vector<TargetRect> areas = areasOf(plan);
                ASSERT_FALSE(areas.empty());
                double filled = 0.0;
                for (std::size_t i = 0; i < areas.size(); ++i) {
                    filled += double(areas[i].width) * areas[i].height;
                    EXPECT_LE(areas[i].x + areas[i].width, map.width);
                    EXPECT_LE(areas[i].y + areas[i].height, map.height);
                    for (std::size_t j = 0; j < i; ++j) EXPECT_FALSE(overlap(areas[i], areas[j]));
                }
                EXPECT_GT(filled, 0.6 * map.width * map.height)
                    << kinds.size() << " lights, " << map.width << " x " << map.height;
            }
        }
    }
}

}  // namespace
