// Material overrides for selected surfaces.
#include "scene/material_override.h"
#include "plan_scenes.h"

#include <gmock/gmock.h>

namespace clerestory::test {
namespace {

using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;

// Three boxes: two of stone, one of them below the node "group", and one of brass.
Scene threeBoxes() {
    Scene scene;
    Material stone, brass;
    stone.name = "stone";
    stone.metallic = 0.0f;
    brass.name = "brass";
    const Index a = addMaterial(scene, stone), b = addMaterial(scene, brass);
    const Index stoneBox = addBoxMesh(scene, "box", a), brassBox = addBoxMesh(scene, "box", b);
    addInstance(scene, addNode(scene, "left"), stoneBox);
    const Index group = addNode(scene, "group");
    addInstance(scene, addNode(scene, "middle", glm::dmat4(1.0), group), stoneBox);
    addInstance(scene, addNode(scene, "right", glm::dmat4(1.0), group), brassBox);
    scene.probes.push_back({.name = "middle"});
    return scene;
}

MaterialOverride of(std::optional<std::string> material, std::optional<std::string> node,
                    double roughness) {
    MaterialOverride o;
    o.material = std::move(material);
    o.node = std::move(node);
    o.roughness = roughness;
    return o;
}

std::vector<float> roughnesses(const Scene& scene, const MaterialBindings& materials) {
    std::vector<float> list;
    for (Index i = 0; i < scene.instances.size(); ++i) {
        list.push_back(materials.material(scene, materials.materialOf(scene, i)).roughness);
    }
    return list;
}

TEST(Overrides, WithoutOverridesTheSceneIsUnchanged) {
    const Scene scene = threeBoxes();
    for (const auto& list :
         {std::vector<MaterialOverride>{}, std::vector<MaterialOverride>{of("no such", {}, 0.5)}}) {
        const MaterialBindings d = bindMaterials(scene, {}, list);
        EXPECT_THAT(d.own, IsEmpty());
        EXPECT_THAT(d.materialOfInstance, IsEmpty());
        EXPECT_THAT(roughnesses(scene, d), ElementsAre(1, 1, 1));
    }
}

TEST(Overrides, ChooseByMaterialByNodeAndByBoth) {
    const Scene scene = threeBoxes();
    const auto with = [&](std::vector<MaterialOverride> list) {
        return roughnesses(scene, bindMaterials(scene, {}, list));
    };
    EXPECT_THAT(with({of("stone", {}, 0.5)}), ElementsAre(0.5f, 0.5f, 1));
    EXPECT_THAT(with({of({}, "group", 0.5)}), ElementsAre(1, 0.5f, 0.5f));
    EXPECT_THAT(with({of({}, "right", 0.5)}), ElementsAre(1, 1, 0.5f));
    EXPECT_THAT(with({of("stone", "group", 0.5)}), ElementsAre(1, 0.5f, 1));
    EXPECT_THAT(with({of({}, {}, 0.5)}), ElementsAre(1, 1, 1));
    EXPECT_THAT(with({of("stone", {}, 0.5), of({}, "group", 0.25)}),
                ElementsAre(0.5f, 0.25f, 0.25f))
        << "the later one takes precedence";
    EXPECT_THAT(with({of({}, "group", 0.25), of("stone", {}, 0.5)}),
                ElementsAre(0.5f, 0.5f, 0.25f));
}

TEST(Overrides, EqualResultsShareAMaterial) {
    const Scene scene = threeBoxes();
    const MaterialBindings d =
        bindMaterials(scene, {}, {of("stone", {}, 0.5), of({}, "right", 0.25)});
    EXPECT_EQ(d.own.size(), 2u);
    EXPECT_THAT(d.materialOfInstance, ElementsAre(2u, 2u, 3u));
    EXPECT_EQ(d.own[0].name, "stone");
}

TEST(Overrides, PermanentOverridesAreEquivalent) {
    Scene scene = threeBoxes();
    const std::vector<MaterialOverride> list{of("stone", {}, 0.5), of({}, "group", 0.25)};
    const auto once = roughnesses(scene, bindMaterials(scene, {}, list));
    applyOverrides(scene, list);
    EXPECT_THAT(sceneProblems(scene), IsEmpty());
    EXPECT_EQ(roughnesses(scene, {}), once);
}

TEST(Overrides, EveryFieldReachesItsMaterialAndNoOther) {
    Scene scene = threeBoxes();
    MaterialOverride o;
    o.baseColor = {0.1, 0.2, 0.3};
    o.metallic = 0.4;
    o.roughness = 0.5;
    o.emissive = {1, 2, 3};
    o.emissiveStrength = 4;
    o.transmission = 0.6;
    o.ior = 1.7;
    o.thickness = 0.8;
    o.attenuationColor = {0.7, 0.8, 0.9};
    o.attenuationDistance = 2;
    o.reflection = Reflection::none;
    o.probe = "middle";
    o.environmentMap = "dusk";
    o.environmentRotation = {0, 1, 0, 0};
    Material m;
    m.baseColor.w = 0.5f;
    apply(scene, o, m);
    EXPECT_EQ(m.baseColor, glm::vec4(0.1f, 0.2f, 0.3f, 0.5f));
    EXPECT_EQ(m.metallic, 0.4f);
    EXPECT_EQ(m.roughness, 0.5f);
    EXPECT_EQ(emittedRadiance(m), glm::vec3(4, 8, 12));
    EXPECT_EQ(m.transmission, 0.6f);
    EXPECT_EQ(m.ior, 1.7f);
    EXPECT_EQ(m.thickness, 0.8f);
    EXPECT_EQ(m.attenuationColor, glm::vec3(0.7f, 0.8f, 0.9f));
    EXPECT_EQ(m.attenuationDistance, 2.0f);
    EXPECT_EQ(m.reflection, Reflection::none);
    EXPECT_EQ(m.probe, "middle");
    EXPECT_EQ(m.environmentMap, "dusk");
    EXPECT_EQ(m.environmentRotation.y, 1.0);
    Material untouched, same;
    apply(scene, {}, untouched);
    EXPECT_EQ(untouched.roughness, same.roughness);
    EXPECT_EQ(untouched.baseColor, same.baseColor);
}

// The material's table and the client's table list the same fields, and a client may set nothing
// that the checks of a scene reject.
TEST(Overrides, RangesLieWithinTheMaterials) {
    MaterialOverride o;
    Material m;
    int factors = 0;
    fields(o, [&](std::string_view name, auto&, const auto& kind, const char*) {
        if constexpr (std::is_same_v<std::decay_t<decltype(kind)>, Range>) {
            bool found = false;
            fields(m, [&](std::string_view field, auto&, const auto& range) {
                if constexpr (std::is_same_v<std::decay_t<decltype(range)>, FactorRange>) {
                    if (field != name) return;
                    found = true;
                    EXPECT_GE(kind.min, double{range.min}) << name;
                    EXPECT_LE(kind.max, double{range.max}) << name;
                }
            });
            EXPECT_TRUE(found) << name;
            ++factors;
        }
    });
    EXPECT_EQ(factors, 22);
}

TEST(Overrides, ReplaceTheTextureAndKeepTheOtherChannelsMean) {
    Scene scene;
    scene.images.push_back({.name = "picture", .mean = {0.5f, 0.5f, 0.25f, 1.0f}});
    scene.textures.push_back({.image = 0});
    const TextureSlot slot{.texture = 0};
    Material before;
    before.baseColorTexture = before.metallicRoughnessTexture = before.emissiveTexture = slot;
    before.transmissionTexture = before.thicknessTexture = before.normalTexture = slot;
    Material m = before;
    MaterialOverride rough;
    rough.roughness = 0.1;
    apply(scene, rough, m);
    EXPECT_EQ(m.roughness, 0.1f);
    EXPECT_EQ(m.metallic, 0.25f);
    EXPECT_FALSE(m.metallicRoughnessTexture.present());
    EXPECT_TRUE(m.baseColorTexture.present());
    MaterialOverride rest;
    rest.baseColor = rest.emissive = glm::dvec3(0.5);
    rest.transmission = rest.thickness = 0.5;
    m = before;
    apply(scene, rest, m);
    EXPECT_FALSE(m.baseColorTexture.present() || m.emissiveTexture.present() ||
                 m.transmissionTexture.present() || m.thicknessTexture.present());
    EXPECT_TRUE(m.metallicRoughnessTexture.present() && m.normalTexture.present());
    m = before;
    m.alphaMode = AlphaMode::mask;
    apply(scene, rest, m);
    EXPECT_TRUE(m.baseColorTexture.present()) << "its holes stay";
}

TEST(Overrides, UnknownTargetsAreNamedWithTheirPointer) {
    const Scene scene = threeBoxes();
    EXPECT_THAT(problems(scene, {of("stone", "left", 1), of({}, "group", 1)}), IsEmpty());
    MaterialOverride bad = of("stoen", "attic", 1);
    bad.probe = "midle";
    bad.environmentRotation = {0, 0, 0, 0.5};
    const auto errors = problems(scene, {of("stone", {}, 1), bad, of({}, {}, 1)});
    EXPECT_THAT(errors, ElementsAre(Field(&FieldError::pointer, "/overrides/1/material"),
                                    Field(&FieldError::pointer, "/overrides/1/node"),
                                    Field(&FieldError::pointer, "/overrides/1/probe"),
                                    Field(&FieldError::pointer, "/overrides/1/environmentRotation"),
                                    Field(&FieldError::pointer, "/overrides/2")));
    EXPECT_THAT(errors[0].detail, HasSubstr("did you mean \"stone\""));
    EXPECT_EQ(errors[0].allowed, "brass, stone");
    EXPECT_EQ(errors[1].allowed, "group, left, middle, right");
}

TEST(Overrides, OnlyTheNearestNamesAreSuggested) {
    Scene scene;
    for (int i = 0; i < 5000; ++i) {
        Material m;
        m.name = "wall " + std::to_string(i);
        scene.materials.push_back(m);
    }
    const auto errors = problems(scene, {of("wall 12x", {}, 1)});
    ASSERT_EQ(errors.size(), 1u);
    EXPECT_THAT(errors[0].allowed, HasSubstr("wall 12"));
    EXPECT_THAT(errors[0].allowed, HasSubstr("and 4992 more"));
    EXPECT_LT(errors[0].allowed.size(), 200u);
}

}  // namespace
}  // namespace clerestory::test
