// Rays on the processor: which passes record and follow them.
#include "plan/cost/cost.h"
#include "plan/graph/features.h"
#include "plan/graph/work.h"
#include "view_planner_support.h"

#include <bit>

using namespace clerestory;
using namespace clerestory::test;

namespace {

FrameRequest traced(FrameRequest request) {
    request.accuracy.curved = CurvedMethod::traced;
    request.accuracy.glass = GlassMethod::traced;
    request.accuracy.planar = PlanarMethod::traced;
    return request;
}

bool within(const TargetRect& rect, const TargetSpec& target) {
    return rect.width > 0 && rect.height > 0 && rect.x + rect.width <= target.width &&
           rect.y + rect.height <= target.height;
}

// Wherever the eye is: in front of the mirrors, among them, with one of them half outside.
TEST(RayPlan, RecordsAreFollowedByTheNextPass) {
    const Scene scene = ballScene();
    for (const double x : {-3.0, -1.4, 0.0, 2.5, 9.0}) {
        const FramePlan plan = planOnProcessor(scene, traced(lookingFrom({x, 0.2, 4.0})));
        const auto recording = [](const Pass& pass) {
            return pass.recorded() && !pass.recorded()->draws.empty();
        };
        std::size_t recordings = 0;
        for (std::size_t i = 0; i < plan.passes.size(); ++i) {
            const Pass& pass = plan.passes[i];
            if (!recording(pass)) continue;
            ++recordings;
            const RecordedDraws& recorded = *pass.recorded();
            ASSERT_LT(i + 1, plan.passes.size());
            const auto* rays = std::get_if<FollowRays>(&plan.passes[i + 1].work);
            ASSERT_NE(rays, nullptr) << toText(plan);
            EXPECT_EQ(rays->records, recorded.targets);
            EXPECT_EQ(rays->rect, recorded.rect);
            EXPECT_EQ(plan.passes[i + 1].target, pass.target);
            EXPECT_TRUE(within(recorded.rect, plan.targets[pass.target])) << x;
            EXPECT_EQ(recorded.targets.size(), 2u) << "one ray for each pixel of a mirror";
            for (const Draw& draw : recorded.draws) EXPECT_TRUE(followsRays(draw));
            for (const Draw& draw : std::get<DrawScene>(pass.work).opaqueDraws) {
                EXPECT_FALSE(followsRays(draw));
            }
        }
        EXPECT_EQ(recordings, count(plan, "rays")) << x;
    }
}

// The next pass reads what a pass records, so that all pictures record into the same targets, which
// hold the largest one.
TEST(RayPlan, AllPicturesShareTheirRecords) {
    Scene scene = ballScene();
    placeAt(scene, addSquareMesh(scene, "wall", addMaterial(scene, mirror())), at(0, 0, -1),
            "wall");
    Material film = mirror();
    film.alphaMode = AlphaMode::blend;
    film.baseColor.a = 0.5f;
    placeAt(scene, addBallMesh(scene, "film", addMaterial(scene, film)), at(0, 0, 2), "film");
    updateContentHash(scene);
    FrameRequest request = traced(lookingFrom({0.0, 0.2, 6.0}));
    request.accuracy.planar = PlanarMethod::mirror;
    const FramePlan plan = planOnProcessor(scene, request);
    std::set<TargetId> records, radiance;
    std::set<std::pair<std::uint32_t, std::uint32_t>> sizes;
    std::size_t passes = 0;
    for (const Pass& pass : plan.passes) {
        const auto* rays = std::get_if<FollowRays>(&pass.work);
        if (!rays) continue;
        ++passes;
        const TargetSpec& drawn = plan.targets[pass.target];
        sizes.insert({drawn.width, drawn.height});
        records.insert(rays->records.begin(), rays->records.end());
        radiance.insert(rays->radiance);
        for (const TargetId id : rays->records) EXPECT_TRUE(within(rays->rect, plan.targets[id]));
        EXPECT_TRUE(within(rays->rect, plan.targets[rays->radiance]));
    }
    ASSERT_GT(sizes.size(), 1u) << toText(plan);
    ASSERT_GT(passes, sizes.size()) << toText(plan);
    EXPECT_EQ(records.size(), 2u);
    EXPECT_EQ(radiance.size(), 1u);
    for (const TargetId id : records) {
        EXPECT_EQ(plan.targets[id].width, plan.width);
        EXPECT_EQ(plan.targets[id].height, plan.height);
    }
}

TEST(RayPlan, GlassHasTwoRaysAndBlendedSurfacesFollow) {
    Scene scene;
    Material glass = clearGlass();
    glass.thickness = 0.5f;
    placeAt(scene, addBallMesh(scene, "ball", addMaterial(scene, glass)), at(0, 0, 0), "ball");
    Material veil = dullGrey();
    veil.alphaMode = AlphaMode::blend;
    veil.baseColor.a = 0.5f;
    placeAt(scene, addSquareMesh(scene, "veil", addMaterial(scene, veil)), at(0, 0, 2), "veil");
    updateContentHash(scene);
    const FramePlan plan = planOnProcessor(scene, traced(lookingFrom({0, 0, 5})));
    ASSERT_EQ(count(plan, "rays"), 1u) << toText(plan);
    EXPECT_EQ(rootOf(plan).recorded.targets.size(), 4u);
    EXPECT_TRUE(rootOf(plan).blendedDraws.empty());
    ASSERT_EQ(count(plan, "blended"), 1u);
    const auto kindAt = [&](std::string_view kind) {
        return std::find_if(plan.passes.begin(), plan.passes.end(),
                            [&](const Pass& pass) { return pass.kind() == kind; });
    };
    EXPECT_LT(kindAt("rays"), kindAt("blended"))
        << "a blended surface covers the light of the rays";
}

TEST(RayPlan, FineFollowsSeveralPathsOfRoughRays) {
    for (const Preset preset : {Preset::draft, Preset::standard, Preset::fine}) {
        FrameRequest request = lookingFrom({0, 0, 4});
        request.accuracy = accuracyOf(preset);
        const FramePlan plan = planOnProcessor(ballScene(), traced(request));
        ASSERT_TRUE(plan.rays.has_value());
        EXPECT_EQ(plan.rays->lobePaths, preset == Preset::fine ? 4u : 1u);
        EXPECT_EQ(plan.rays->glassLobePaths, preset == Preset::draft ? 1u : 4u);
        const bool printed = toText(plan).find("rough mirrors by 4 paths each") != std::string::npos;
        EXPECT_EQ(printed, preset == Preset::fine) << toText(plan);
    }
}

TEST(RayPlan, PathsOfRoughRaysAreWorkAndLowerTheError) {
    EXPECT_EQ(pathsOfRay(4, 0.05, true), 1.0) << "smooth";
    EXPECT_EQ(pathsOfRay(4, 0.3, false), 1.0) << "rays in the programs of the surfaces";
    EXPECT_EQ(pathsOfRay(4, 0.3, true), 4.0);
    EXPECT_LT(tracedError(0.4, 4.0), tracedError(0.4));
    EXPECT_EQ(tracedError(0.05, 4.0), tracedError(0.05));
    const Work one{.rayPixels = 1e5, .rays = 1.0, .processorRays = true};
    Work four = one;
    four.paths = 4.0;
    EXPECT_GT(milliseconds(four), 2.0 * milliseconds(one));

    FrameRequest request = traced(lookingFrom({0, 0, 4}));
    const auto samples = [&](std::uint32_t paths) {
        request.accuracy.raySamples = request.accuracy.glassRaySamples = paths;
        return shadedSamples(planOnProcessor(ballScene(), request));
    };
    EXPECT_GT(samples(8), samples(1)) << "the limit of work counts them";
    EXPECT_EQ(samples(8) - samples(4), 4 * (samples(4) - samples(1)) / 3);
}

// Bumps turn reflections to where a mirrored view shows nothing: rays follow them, and without rays
// the environment map is nearer to the truth.
TEST(RayPlan, BumpyMirrorsAreNotFlat) {
    EXPECT_EQ(mirrorError(0.1, 0.0), mirrorError(0.1));
    EXPECT_LT(mirrorError(0.1, 0.02), 0.5 * environmentError(0.1));
    EXPECT_GT(mirrorError(0.1, 0.35), environmentError(0.1));
    const auto taken = [](float scale, Rays rays) {
        Scene scene = mirrorScene(mirror(0.1f));
        scene.images.push_back(
            {.name = "bumps", .width = 1, .height = 1, .levels = 1, .slope = 0.5f});
        scene.images.back().texels = {128, 128, 255, 255};
        scene.textures.push_back({.image = 0});
        for (Material& m : scene.materials) {
            if (m.metallic < 1.0f) continue;
            m.normalTexture.texture = 0;
            m.normalScale = scale;
        }
        updateContentHash(scene);
        const EnvironmentMap map = plainMap();
        const Pose pose = poseAt(scene, 0.0);
        const FramePlan plan = planFrame({.scene = scene,
                                          .pose = pose,
                                          .environment = map,
                                          .maps = {},
                                          .resident = {},
                                          .limits = {.rays = rays}},
                                         lookingFrom({0, 0, 5}));
        for (const Decision& decision : plan.decisions) {
            if (decision.effect == Effect::planarReflection) return decision.taken;
        }
        ADD_FAILURE() << "no mirror was planned";
        return Method::environment;
    };
    EXPECT_EQ(taken(0.0f, Rays::processor), Method::mirror);
    EXPECT_EQ(taken(0.7f, Rays::processor), Method::traced);
    EXPECT_EQ(taken(0.0f, Rays::none), Method::mirror);
    EXPECT_EQ(taken(0.7f, Rays::none), Method::environment);
}

// Drivers of graphics cards have too few samplers for all maps and those of rays.
TEST(RayPlan, ProgramsThatTraceRaysLeaveOutMapsOfLayersAndSaySo) {
    Scene scene;
    Material coated = dullGrey();
    coated.clearcoat = coated.iridescence = coated.diffuseTransmission = 1.0f;
    coated.sheenColor = glm::vec3(0.2f);
    for (TextureSlot* slot :
         {&coated.specularTexture, &coated.specularColorTexture, &coated.clearcoatTexture,
          &coated.clearcoatRoughnessTexture, &coated.clearcoatNormalTexture,
          &coated.sheenColorTexture, &coated.sheenRoughnessTexture, &coated.iridescenceTexture,
          &coated.iridescenceThicknessTexture, &coated.diffuseTransmissionTexture,
          &coated.diffuseTransmissionColorTexture}) {
        slot->texture = 0;
    }
    scene.images.push_back({.name = "white", .width = 1, .height = 1, .levels = 1});
    scene.images.back().texels = {255, 255, 255, 255};
    scene.textures.push_back({.image = 0});
    placeAt(scene, addSquareMesh(scene, "floor", addMaterial(scene, coated)), at(0, 0, 0), "floor");
    updateContentHash(scene);
    constexpr Features kMaps = ofLayers(
        LAYER_SPECULAR_MAP | LAYER_SPECULAR_COLOR_MAP | LAYER_CLEARCOAT_MAP |
        LAYER_CLEARCOAT_ROUGHNESS_MAP | LAYER_CLEARCOAT_NORMAL_MAP | LAYER_SHEEN_COLOR_MAP |
        LAYER_SHEEN_ROUGHNESS_MAP | LAYER_IRIDESCENCE_MAP | LAYER_IRIDESCENCE_THICKNESS_MAP |
        LAYER_DIFFUSE_TRANSMISSION_MAP | LAYER_DIFFUSE_TRANSMISSION_COLOR_MAP);
    for (const auto& [rays, maps] : {std::pair{Rays::shader, 8}, {Rays::processor, 11}}) {
        const FramePlan plan = planWith(rays, scene, traced(lookingFrom({0, 0, 4})));
        int tracing = 0;
        for (const Pass& pass : plan.passes) {
            for (const std::span<const Draw> draws : pass.drawLists()) {
                for (const Draw& draw : draws) {
                    if (!followsRays(draw)) continue;
                    ++tracing;
                    EXPECT_EQ(std::popcount(draw.features & kMaps), maps) << toText(plan);
                }
            }
        }
        EXPECT_GT(tracing, 0) << toText(plan);
        const bool reported =
            toText(plan).find("3 textures of layers are left out") != std::string::npos;
        EXPECT_EQ(reported, rays == Rays::shader) << toText(plan);
    }
}

}  // namespace
