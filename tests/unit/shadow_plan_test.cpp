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

    FramePlan plan(Preset preset, const glm::dvec3& eye = {0.0, 0.0, 8.0},
                   std::optional<double> orthographicHeight = std::nullopt) const {
        FrameRequest request = lookingFrom(eye);
        request.camera.orthographicHeight = orthographicHeight;
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

// Half the edge of the sun's picture, metres.
double reachOfSun(const Lit& lit) {
    const PlacedLight sun = lit.plan(Preset::standard).lights.at(0);
    return sun.shadow ? 1.0 / sun.shadow->view.clipFromView[0][0] : 0.0;
}

// A sun in the direction of `toLight` over two boxes of 2 m whose bottoms are at -1 m.
Lit underSun(const glm::dvec3& toLight) {
    Lit lit;
    const Index node = addNode(lit.scene, "sun", worldFromLookAt(toLight, {}, {1, 0, 0}));
    lit.scene.lights.push_back({.name = "sun",
                                .node = node,
                                .kind = LightKind::directional,
                                .intensity = glm::vec3(10.0f)});
    return lit;
}

// What is below everything shades nothing, and does not make the picture of the sun coarser.
TEST(ShadowPlan, GroundsTakeNothingOfThePicture) {
    const glm::dvec3 slanted(0.0, 3.0, 1.0);
    const double without = reachOfSun(underSun(slanted));
    EXPECT_LT(without, 4.0);
    const auto lying = [&](Lit& lit, Index mesh, double height, double size, double thick) {
        const glm::dmat4 world =
            glm::translate(glm::dmat4(1.0), glm::dvec3(0.0, height, 0.0)) *
            glm::rotate(glm::dmat4(1.0), glm::radians(-90.0), glm::dvec3(1.0, 0.0, 0.0)) *
            glm::scale(glm::dmat4(1.0), glm::dvec3(size, size, thick));
        addInstance(lit.scene, addNode(lit.scene, "ground", world), mesh);
    };
    const auto reachWith = [&](const glm::dvec3& toLight, bool slab, bool twoSided, double height) {
        Lit lit = underSun(toLight);
        Material material;
        material.doubleSided = twoSided;
        const Index m = addMaterial(lit.scene, material);
        const Index mesh =
            slab ? addBoxMesh(lit.scene, "slab", m) : addSquareMesh(lit.scene, "square", m);
        lying(lit, mesh, height, 100.0, slab ? 0.2 : 1.0);
        return reachOfSun(lit);
    };
    for (const bool twoSided : {false, true}) {
        EXPECT_NEAR(reachWith(slanted, false, twoSided, -1.0), without, 1e-6);
        EXPECT_NEAR(reachWith(slanted, false, twoSided, -5.0), without, 1e-6);
        EXPECT_NEAR(reachWith(slanted, false, twoSided, -0.9), without, 1e-6)
            << "they sink into it";
    }
    EXPECT_NEAR(reachWith(slanted, true, false, -1.2), without, 1e-6) << "a slab";
    // These shade others.
    EXPECT_GT(reachWith(slanted, true, false, 4.0), 90.0) << "a slab above them";
    EXPECT_GT(reachWith({0.0, -3.0, 1.0}, true, false, -5.0), 90.0) << "lit from below";
    // And this one itself.
    Lit lit = underSun(slanted);
    lying(lit, addBallMesh(lit.scene, "hill", addMaterial(lit.scene, {})), -21.0, 100.0, 20.0);
    EXPECT_GT(reachOfSun(lit), 90.0);
}

// A sun over boxes of 2 m about the origin and one 800 m away.
Lit largeUnderSun() {
    Lit lit = underSun({0.0, 3.0, 1.0});
    place(lit.scene, lit.scene.instances.front().mesh, {800.0, 0.0, 0.0});
    return lit;
}

std::size_t nearerOf(const FramePlan& plan) {
    return plan.lights.at(0).shadow->nearer.size();
}

// Where texels are much larger than pixels there are nearer pictures, each with smaller texels than
// the one before, in places of their own and in a map of the same size for all observers.
TEST(ShadowPlan, SunsHaveNearerPicturesOfWhatIsNear) {
    const Lit lit = largeUnderSun();
    std::vector<std::uint32_t> widths;
    for (const double z : {1.5, 2.5, 4.0}) {
        const FramePlan plan = lit.plan(Preset::standard, {0.0, 0.0, z});
        const LightShadow& shadow = *plan.lights.at(0).shadow;
        ASSERT_GE(shadow.nearer.size(), 1u) << z;
        ASSERT_LE(shadow.nearer.size(), kMaxNearShadows);
        const TargetSpec& map = plan.targets.at(plan.shadowMap);
        EXPECT_NE(map.partKey, 0u);
        widths.push_back(map.width);
        double texel = texelOf(shadow.view, shadow.tile);
        std::vector<TargetRect> areas{shadow.tile};
        for (const NearShadow& picture : shadow.nearer) {
            EXPECT_LT(texelOf(picture.view, picture.tile), 0.5 * texel) << z;
            texel = texelOf(picture.view, picture.tile);
            for (const TargetRect& other : areas) EXPECT_FALSE(overlap(picture.tile, other));
            areas.push_back(picture.tile);
            EXPECT_LE(picture.tile.x + picture.tile.width, map.width);
            EXPECT_LE(picture.tile.y + picture.tile.height, map.height);
        }
    }
    EXPECT_EQ(widths, std::vector(3, widths.front()));
    // The scene is as wide as the picture, there is no distance in it, or it is not large.
    EXPECT_EQ(nearerOf(lit.plan(Preset::standard, {0.0, 0.0, 600.0})), 0u);
    EXPECT_EQ(nearerOf(lit.plan(Preset::standard, {0.0, 0.0, 1.5}, 4.0)), 0u);
    EXPECT_EQ(nearerOf(underSun({0.0, 3.0, 1.0}).plan(Preset::standard)), 0u);
}

}  // namespace
