// The optical class of materials on meshes.
#include "scene/classification.h"
#include "plan_scenes.h"
#include "scene/flat_mirrors.h"
#include "scene/texture_images.h"

#include <gmock/gmock.h>

#include <functional>

namespace clerestory::test {
namespace {

using testing::HasSubstr;

struct OverriddenScene {
    const char* name;
    std::function<void(Material&)> make;
    bool emitter;
    Glass glass;
    Reflector flat, curved;
    ReflectorReason reason;  // of the flat part
};
class OnABox : public testing::TestWithParam<OverriddenScene> {};

Material dielectric(float roughness) {
    Material m;
    m.metallic = 0.0f;
    m.roughness = roughness;
    return m;
}

TEST_P(OnABox, IsClassifiedByItsMaterial) {
    Material m = dielectric(0.6f);
    GetParam().make(m);
    Scene scene;
    place(scene, addBoxMesh(scene, "box", addMaterial(scene, m)), {0, 0, 0}, 1);
    const MaterialClass c = classOf(scene, scene.materials[0]);
    EXPECT_EQ(c.emitter, GetParam().emitter);
    EXPECT_EQ(c.onFlat, GetParam().flat);
    EXPECT_EQ(c.onCurved, GetParam().curved);
    EXPECT_EQ(c.reasonFlat, GetParam().reason);
    const auto surfaces = surfacesOf(scene);
    ASSERT_EQ(surfaces.size(), GetParam().flat == Reflector::flat ? 6u : 1u);
    for (const Surface& s : surfaces) {
        EXPECT_EQ(s.glass, GetParam().glass);
        EXPECT_EQ(s.emitter, GetParam().emitter);
        EXPECT_EQ(s.reflector, GetParam().flat);
        EXPECT_EQ(s.flatPart != kNone, GetParam().flat == Reflector::flat);
        EXPECT_FALSE(reflectorReason(scene, {}, s).empty());
        EXPECT_FALSE(glassReason(scene, {}, s).empty());
        EXPECT_FALSE(emitterReason(scene, {}, s).empty());
    }
}

constexpr auto kNo = Reflector::none, kFlat = Reflector::flat, kCurved = Reflector::curved;
INSTANTIATE_TEST_SUITE_P(
    Materials, OnABox,
    testing::Values(
        OverriddenScene{"plain", [](Material&) {}, false, Glass::none, kNo, kNo,
                        ReflectorReason::roughDielectric},
        OverriddenScene{"metal", [](Material& m) { m.metallic = 1, m.roughness = 0.2f; }, false,
                        Glass::none, kFlat, kCurved, ReflectorReason::metal},
        OverriddenScene{"roughMetal", [](Material& m) { m.metallic = 1, m.roughness = 0.51f; },
                        false, Glass::none, kNo, kNo, ReflectorReason::roughMetal},
        OverriddenScene{"polished", [](Material& m) { m.roughness = 0.3f; }, false, Glass::none,
                        kFlat, kNo, ReflectorReason::gloss},
        OverriddenScene{"polishedAndBright",
                        [](Material& m) { m.roughness = 0.1f, m.specularColor = glm::vec3(4.0f); },
                        false, Glass::none, kFlat, kCurved, ReflectorReason::bright},
        OverriddenScene{"brightGlass",
                        [](Material& m) {
                            m.roughness = 0.1f, m.specularColor = glm::vec3(4.0f);
                            m.transmission = 1;
                        },
                        false, Glass::pane, kFlat, kNo, ReflectorReason::gloss},
        OverriddenScene{"polishedWithoutSpecular",
                        [](Material& m) { m.roughness = 0.3f, m.specular = 0.0f; }, false,
                        Glass::none, kNo, kNo, ReflectorReason::noSpecular},
        OverriddenScene{"polishedLeaf",
                        [](Material& m) { m.roughness = 0.1f, m.alphaMode = AlphaMode::mask; },
                        false, Glass::none, kNo, kNo, ReflectorReason::alphaMasked},
        OverriddenScene{"asked", [](Material& m) { m.reflection = Reflection::mirror; }, false,
                        Glass::none, kFlat, kCurved, ReflectorReason::requested},
        OverriddenScene{
            "refused",
            [](Material& m) { m.metallic = 1, m.roughness = 0, m.reflection = Reflection::none; },
            false, Glass::none, kNo, kNo, ReflectorReason::disabled},
        OverriddenScene{"unlitMirrorLampOfGlass",
                        [](Material& m) {
                            m.unlit = true, m.metallic = 1, m.roughness = 0,
                            m.emissive = glm::vec3(1);
                            m.transmission = 1, m.reflection = Reflection::mirror;
                        },
                        false, Glass::none, kNo, kNo, ReflectorReason::unlit},
        OverriddenScene{"lamp",
                        [](Material& m) {
                            m.emissive = {0, 2, 0};
                        },
                        true, Glass::none, kNo, kNo, ReflectorReason::roughDielectric},
        OverriddenScene{"lampSwitchedOff",
                        [](Material& m) {
                            m.emissive = {0, 2, 0}, m.emissiveStrength = 0;
                        },
                        false, Glass::none, kNo, kNo, ReflectorReason::roughDielectric},
        OverriddenScene{"thinGlass", [](Material& m) { m.transmission = 1, m.roughness = 0; },
                        false, Glass::pane, kFlat, kNo, ReflectorReason::gloss},
        OverriddenScene{
            "thickGlass",
            [](Material& m) { m.transmission = 0.5f, m.thickness = 1, m.roughness = 0.4f; }, false,
            Glass::solid, kNo, kNo, ReflectorReason::roughDielectric},
        OverriddenScene{"metalLetsNothingThrough",
                        [](Material& m) { m.transmission = 1, m.metallic = 1, m.roughness = 0.9f; },
                        false, Glass::none, kNo, kNo, ReflectorReason::roughMetal},
        OverriddenScene{"coverageIsNoGlass",  // erratum G6
                        [](Material& m) { m.alphaMode = AlphaMode::blend, m.baseColor.w = 0.1f; },
                        false, Glass::none, kNo, kNo, ReflectorReason::roughDielectric},
        OverriddenScene{"ownMap", [](Material& m) { m.environmentMap = "dusk"; }, false,
                        Glass::none, kCurved, kCurved, ReflectorReason::map},
        OverriddenScene{"ownProbe", [](Material& m) { m.probe = "middle"; }, false, Glass::none,
                        kCurved, kCurved, ReflectorReason::probe}),
    [](const auto& row) { return row.param.name; });

TEST(Classification, TexturesContributeTheirMean) {
    Scene scene;
    scene.images.push_back({.name = "half", .mean = {1.0f, 0.5f, 0.25f, 1.0f}});
    scene.textures.push_back({.image = 0});
    Material m;  // metallic 1, roughness 1
    m.metallicRoughnessTexture.texture = 0;
    const MaterialClass c = classOf(scene, m);
    EXPECT_EQ(c.metallic, 0.25f);
    EXPECT_EQ(c.roughness, 0.5f);
    EXPECT_EQ(c.reasonFlat, ReflectorReason::roughDielectric);
}

// A road with puddles: a plane that is rough on average mirrors in its smooth patches.
TEST(Classification, SmoothPatchesMirrorInAPlane) {
    Scene scene;
    TextureImage road{.name = "road", .width = 4, .height = 5};
    for (int i = 0; i < 20; ++i) {
        const std::uint8_t green = i < 3 ? 10 : 200;
        road.texels.insert(road.texels.end(), {0, green, 0, 255});
    }
    buildLevels(road);
    EXPECT_FLOAT_EQ(road.leastGreen, 10.0f / 255.0f);
    scene.images.push_back(road);
    scene.textures.push_back({.image = 0});
    Material m;
    m.metallicRoughnessTexture.texture = 0;
    const MaterialClass c = classOf(scene, m);
    EXPECT_GT(c.roughness, kGlossRoughness);
    EXPECT_FLOAT_EQ(c.smoothest, 10.0f / 255.0f);
    EXPECT_EQ(c.onFlat, Reflector::flat);
    EXPECT_EQ(c.reasonFlat, ReflectorReason::patches);
    EXPECT_EQ(c.onCurved, Reflector::none);
    m.roughness = 0.0f;  // everywhere
    EXPECT_EQ(classOf(scene, m).reasonFlat, ReflectorReason::gloss);
    scene.images[0].leastGreen = 0.5f;
    m.roughness = 1.0f;
    EXPECT_EQ(classOf(scene, m).onFlat, Reflector::none);
}

TEST(Classification, ReflectanceIsThatAlongTheNormal) {
    Scene scene;
    Material glass = dielectric(0.0f);
    glass.ior = 1.5f;
    EXPECT_NEAR(classOf(scene, glass).reflectance, 0.04f, 1e-6f);
    glass.ior = 1.0f;
    EXPECT_EQ(classOf(scene, glass).reflectance, 0.0f);
    Material metal;
    metal.baseColor = {0.9f, 0.6f, 0.3f, 1.0f};
    EXPECT_NEAR(classOf(scene, metal).reflectance, 0.6f, 1e-6f);
}

// A sheet with a dome: one flat part, and a rest.
MeshDraft domedSheet(Index material) {
    MeshDraft draft{.name = "domed", .material = material};
    constexpr int kSquares = 40;
    for (int j = 0; j <= kSquares; ++j) {
        for (int i = 0; i <= kSquares; ++i) {
            const float x = 2.0f * static_cast<float>(i) / kSquares - 1.0f,
                        y = 2.0f * static_cast<float>(j) / kSquares - 1.0f;
            Vertex v;
            v.position = {x, y, std::max(0.0f, 0.2f - x * x - y * y)};
            draft.vertices.push_back(v);
        }
    }
    for (std::uint32_t j = 0; j < kSquares; ++j) {
        for (std::uint32_t i = 0; i < kSquares; ++i) {
            const std::uint32_t a = j * (kSquares + 1) + i, b = a + kSquares + 1;
            for (const std::uint32_t k : {a, a + 1, b, a + 1, b + 1, b}) draft.indices.push_back(k);
        }
    }
    return draft;
}

TEST(Classification, CoversEveryClusterOnceAndSeparatesFlatParts) {
    Scene scene;
    Material metal;
    metal.roughness = 0.1f;
    const Index mesh = addMesh(scene, domedSheet(addMaterial(scene, metal)));
    place(scene, mesh, {0, 0, 0}, 1);
    place(scene, mesh, {5, 0, 0}, 1);
    const auto surfaces = surfacesOf(scene);
    ASSERT_EQ(surfaces.size(), 4u);
    for (const std::size_t i : {std::size_t{0}, std::size_t{2}}) {
        EXPECT_EQ(surfaces[i].instance, i / 2);
        EXPECT_EQ(surfaces[i].reflector, Reflector::flat);
        EXPECT_EQ(surfaces[i + 1].reflector, Reflector::curved);
        EXPECT_EQ(surfaces[i + 1].firstCluster,
                  surfaces[i].firstCluster + surfaces[i].clusterCount);
        EXPECT_EQ(surfaces[i].clusterCount + surfaces[i + 1].clusterCount,
                  scene.meshes[0].clusterCount);
        EXPECT_NEAR(surfaces[i].area + surfaces[i + 1].area, scene.meshes[0].area, 1e-9);
    }
    EXPECT_THAT(reflectorReason(scene, {}, surfaces[0]), HasSubstr("roughness 0.1"));
}

TEST(Classification, FlatVolumesArePanes) {
    Scene scene;
    Material glass = dielectric(0.0f);
    glass.transmission = 1.0f;
    glass.thickness = 0.01f;
    const Index material = addMaterial(scene, glass);
    MeshDraft quad{.name = "quad", .material = material};
    for (const glm::vec2 p : {glm::vec2(0, 0), glm::vec2(1, 0), glm::vec2(1, 1), glm::vec2(0, 1)}) {
        quad.vertices.emplace_back();
        quad.vertices.back().position = {p, 0.0f};
    }
    quad.indices = {0, 1, 2, 0, 2, 3};
    place(scene, addMesh(scene, quad), {0, 0, 0}, 1);
    quad.indices.insert(quad.indices.end(), {2, 1, 0, 3, 2, 0});  // and its back
    place(scene, addMesh(scene, quad), {0, 0, 0}, 1);
    place(scene, addBoxMesh(scene, "box", material), {0, 0, 0}, 1);
    for (const Surface& s : surfacesOf(scene)) {
        EXPECT_EQ(s.glass, s.instance == 2 ? Glass::solid : Glass::pane);
        EXPECT_THAT(glassReason(scene, {}, s), HasSubstr(s.instance == 2 ? "volume" : "pane"));
    }
}

TEST(Classification, UsesTheFramesMaterials) {
    Scene scene;
    place(scene, addBoxMesh(scene, "box", addMaterial(scene, dielectric(1.0f))), {0, 0, 0}, 1);
    addInstance(scene, 0, 0);
    MaterialBindings materials;
    materials.own.push_back(dielectric(0.05f));
    materials.materialOfInstance = {0, 1};
    const auto surfaces = surfacesOf(scene, materials);
    ASSERT_EQ(surfaces.size(), 1u + 6u);
    EXPECT_TRUE(surfaces[0].plain());
    EXPECT_EQ(surfaces[1].reflector, Reflector::flat);
    EXPECT_EQ(surfaces[1].material, 1u);
    EXPECT_EQ(surfaces[1].reason, ReflectorReason::gloss);
}

TEST(FlatMirrors, AreSmoothMetalsInOnePlane) {
    const auto mirrorsOf = [](const Material& material, int count = 1) {
        Scene scene;
        const Index square = addSquareMesh(scene, "square", addMaterial(scene, material));
        for (int i = 0; i < count; ++i) {
            placeAt(scene, square, glm::translate(glm::dmat4(1.0), {0.0, 0.0, 1.0 * i}));
        }
        return flatMirrors(scene, restPose(scene), {}, surfacesOf(scene));
    };
    const Material silver{.roughness = 0.05f};
    EXPECT_EQ(mirrorsOf(silver).size(), 1u);
    EXPECT_EQ(mirrorsOf(silver, 40).size(), kMaxFlatMirrors);
    Material other = silver;
    other.roughness = 0.3f;
    EXPECT_TRUE(mirrorsOf(other).empty());
    other = silver;
    other.metallic = 0.0f;
    EXPECT_TRUE(mirrorsOf(other).empty());
    other = silver;
    other.clearcoat = 1.0f;
    EXPECT_TRUE(mirrorsOf(other).empty());
    other = silver;
    other.alphaMode = AlphaMode::blend;
    EXPECT_TRUE(mirrorsOf(other).empty());
}

TEST(FlatMirrors, ShowImagesOfLamps) {
    struct Lamp {
        LightKind kind = LightKind::point;
        glm::dvec3 position{0.0};
        glm::vec3 toLight{0.0f, 0.0f, 1.0f};
    };
    Scene scene;
    const Index square = addSquareMesh(scene, "square", addMaterial(scene, {.roughness = 0.0f}));
    // From -1 to 1 in x and y; its front has z > 3.
    placeAt(scene, square, glm::translate(glm::dmat4(1.0), {0.0, 0.0, 3.0}));
    const FlatMirror mirror = flatMirrors(scene, restPose(scene), {}, surfacesOf(scene)).at(0);
    const Lamp lamp{.position = {0.5, 0.0, 5.0}};
    EXPECT_EQ(mirror.imageOf(lamp).position, glm::dvec3(0.5, 0.0, 1.0));
    EXPECT_EQ(mirror.imageOf(lamp).toLight, glm::vec3(0.0f, 0.0f, -1.0f));
    EXPECT_TRUE(mirror.shows(lamp, {-0.5, 0.0, 4.0}));
    EXPECT_FALSE(mirror.shows(lamp, {9.0, 0.0, 4.0}));   // next to it
    EXPECT_FALSE(mirror.shows(lamp, {-0.5, 0.0, 2.0}));  // behind it
    const Lamp sun{.kind = LightKind::directional, .toLight = {0.6f, 0.0f, 0.8f}};
    EXPECT_TRUE(mirror.shows(sun, {-0.7, 0.0, 4.0}));
    EXPECT_FALSE(mirror.shows(sun, {0.7, 0.0, 4.0}));
    EXPECT_TRUE(mirror.relativeTo({1.0, 2.0, 3.0}).shows(sun, {-1.7, -2.0, 1.0}));
}

}  // namespace
}  // namespace clerestory::test
