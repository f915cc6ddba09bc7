// KHR_animation_pointer and KHR_node_visibility: pointers, the values of a moment, and files that
// are wrong.
#include "import_support.h"
#include "tests/support/glb_builder.h"

#include "scene/animated_field.h"
#include "scene/import/cache/blob.h"
#include "scene/import/gltf/animation_pointers.h"
#include "scene/light_override.h"
#include "scene/material_override.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include <set>

namespace clerestory::test {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::IsEmpty;

// A file with a triangle, and animations whose channels are pointers.
class PointerFile {
public:
    PointerFile() {
        builder_.primitive()["attributes"]["POSITION"] = builder_.accessor(
            builder_.view(bytesOf(std::vector<glm::vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}})),
            kGltfFloat, 3, "VEC3");
        json()["animations"] = {{{"name", "go"},
                                 {"channels", nlohmann::json::array()},
                                 {"samplers", nlohmann::json::array()}}};
    }
    nlohmann::json& json() { return builder_.json(); }

    // Keys at 0, 1, 2... seconds, each of `components` numbers.
    void animate(const std::string& pointer, std::size_t components,
                 const std::vector<float>& values, const char* interpolation = "LINEAR") {
        static const char* kTypes[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
        const bool cubic = std::string(interpolation) == "CUBICSPLINE";
        std::vector<float> times;
        for (std::size_t i = 0; i < values.size() / components / (cubic ? 3 : 1); ++i) {
            times.push_back(static_cast<float>(i));
        }
        const int input =
            builder_.accessor(builder_.view(bytesOf(times)), kGltfFloat, times.size(), "SCALAR");
        const int output = builder_.accessor(builder_.view(bytesOf(values)), kGltfFloat,
                                             values.size() / components, kTypes[components]);
        auto& animation = json()["animations"][0];
        animation["samplers"].push_back(
            {{"input", input}, {"output", output}, {"interpolation", interpolation}});
        nlohmann::json target{{"path", "pointer"}};
        target["extensions"]["KHR_animation_pointer"]["pointer"] = pointer;
        animation["channels"].push_back(
            {{"sampler", animation["samplers"].size() - 1}, {"target", target}});
    }
    // Keys at 0, 1, 2... as bytes, held until the next.
    void show(int node, const std::vector<std::uint8_t>& visible) {
        std::vector<float> times;
        for (std::size_t i = 0; i < visible.size(); ++i) times.push_back(static_cast<float>(i));
        const int input =
            builder_.accessor(builder_.view(bytesOf(times)), kGltfFloat, times.size(), "SCALAR");
        const int output = builder_.accessor(builder_.view(bytesOf(visible)), kGltfUnsignedByte,
                                             visible.size(), "SCALAR");
        auto& animation = json()["animations"][0];
        animation["samplers"].push_back(
            {{"input", input}, {"output", output}, {"interpolation", "STEP"}});
        nlohmann::json target{{"path", "pointer"}};
        target["extensions"]["KHR_animation_pointer"]["pointer"] =
            "/nodes/" + std::to_string(node) + "/extensions/KHR_node_visibility/visible";
        animation["channels"].push_back(
            {{"sampler", animation["samplers"].size() - 1}, {"target", target}});
    }
    Scene scene() {
        std::set<std::string> used{"KHR_animation_pointer", "KHR_lights_punctual"};
        json()["extensionsUsed"] = used;
        const TemporaryFolder folder;
        Scene scene = importScene(folder.write("scene.glb", builder_.glb()));
        EXPECT_THAT(sceneProblems(scene), IsEmpty());
        return scene;
    }

private:
    GlbBuilder builder_;
};

Scene stored(const Scene& scene) {
    std::vector<std::byte> blob;
    writeScene(scene, [&](const void* bytes, std::size_t count) {
        const auto* first = static_cast<const std::byte*>(bytes);
        blob.insert(blob.end(), first, first + count);
    });
    return readScene(blob);
}

Material materialAt(const Scene& scene, double time, Index index = 0) {
    const Pose pose = poseAt(scene, time);
    const MaterialBindings bound = bindMaterials(scene, pose, {});
    return bound.material(scene, bound.materialOf(scene, index));
}

TEST(AnimationPointers, NameTheFactorsOfOverrides) {
    const std::pair<const char*, const char*> kRows[] = {
        {"pbrMetallicRoughness/baseColorFactor", "baseColor"},
        {"pbrMetallicRoughness/metallicFactor", "metallic"},
        {"pbrMetallicRoughness/roughnessFactor", "roughness"},
        {"emissiveFactor", "emissive"},
        {"extensions/KHR_materials_emissive_strength/emissiveStrength", "emissiveStrength"},
        {"extensions/KHR_materials_transmission/transmissionFactor", "transmission"},
        {"extensions/KHR_materials_ior/ior", "ior"},
        {"extensions/KHR_materials_volume/thicknessFactor", "thickness"},
        {"extensions/KHR_materials_volume/attenuationColor", "attenuationColor"},
        {"extensions/KHR_materials_volume/attenuationDistance", "attenuationDistance"},
        {"extensions/KHR_materials_dispersion/dispersion", "dispersion"},
        {"extensions/KHR_materials_clearcoat/clearcoatFactor", "clearcoat"},
        {"extensions/KHR_materials_clearcoat/clearcoatRoughnessFactor", "clearcoatRoughness"},
        {"extensions/KHR_materials_sheen/sheenColorFactor", "sheenColor"},
        {"extensions/KHR_materials_sheen/sheenRoughnessFactor", "sheenRoughness"},
        {"extensions/KHR_materials_iridescence/iridescenceFactor", "iridescence"},
        {"extensions/KHR_materials_iridescence/iridescenceIor", "iridescenceIor"},
        {"extensions/KHR_materials_iridescence/iridescenceThicknessMaximum",
         "iridescenceThickness"},
        {"extensions/KHR_materials_anisotropy/anisotropyStrength", "anisotropy"},
        {"extensions/KHR_materials_anisotropy/anisotropyRotation", "anisotropyRotation"},
        {"extensions/KHR_materials_diffuse_transmission/diffuseTransmissionFactor",
         "diffuseTransmission"},
        {"extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorFactor",
         "diffuseTransmissionColor"}};
    std::set<std::string> animated;
    for (const auto& [pointer, field] : kRows) {
        const auto target = animatedBy(std::string("/materials/3/") + pointer);
        ASSERT_TRUE(target) << pointer;
        EXPECT_EQ(target->property, AnimatedProperty::material);
        EXPECT_EQ(target->index, 3u);
        EXPECT_EQ(target->field, field);
        animated.insert(field);
    }
    // Every number that an override can set.
    const MaterialOverride none;
    fields(none, [&](const char* name, const auto&, const auto& kind, const char*) {
        if constexpr (std::is_same_v<std::decay_t<decltype(kind)>, Range>) {
            EXPECT_TRUE(animated.contains(name)) << name;
        }
    });
}

TEST(AnimationPointers, NameTexturesLightsCamerasAndNodes) {
    const auto field = [](const char* pointer) {
        const auto target = animatedBy(pointer);
        return target ? target->field : "unknown";
    };
    EXPECT_EQ(field("/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/"
                    "KHR_texture_transform/offset"),
              "baseColorTexture.offset");
    EXPECT_EQ(field("/materials/0/emissiveTexture/extensions/KHR_texture_transform/rotation"),
              "emissiveTexture.rotation");
    EXPECT_EQ(field("/materials/0/extensions/KHR_materials_sheen/sheenColorTexture/extensions/"
                    "KHR_texture_transform/scale"),
              "sheenColorTexture.scale");
    EXPECT_EQ(field("/extensions/KHR_lights_punctual/lights/0/spot/outerConeAngle"),
              "outerConeAngle");
    EXPECT_EQ(field("/cameras/1/perspective/yfov"), "yfov");
    EXPECT_EQ(animatedBy("/nodes/7/rotation")->property, AnimatedProperty::rotation);
    EXPECT_EQ(animatedBy("/nodes/7/rotation")->index, 7u);
    for (const char* unknown :
         {"", "/", "/materials", "/materials/", "/materials/x/emissiveFactor", "/materials/0",
          "/materials/-1/emissiveFactor", "/materials/99999999999/emissiveFactor",
          "/materials/0/emissiveFactor/0", "/materials/0/name", "/materials/0/doubleSided",
          "/materials/0/emissiveTexture/extensions/KHR_texture_transform/texCoord",
          "/materials/0/a/emissiveTexture/extensions/KHR_texture_transform/offset", "/nodes/0/mesh",
          "/cameras/0/perspective/aspectRatio", "/animations/0/name",
          "/extensions/KHR_lights_punctual/lights/0/type", "materials/0/emissiveFactor"}) {
        EXPECT_FALSE(animatedBy(unknown)) << unknown;
    }
}

TEST(AnimationPointers, AMomentHasTheMaterialsOfTheClip) {
    PointerFile file;
    file.json()["materials"] = {
        {{"name", "paint"},
         {"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, 0.5}}, {"roughnessFactor", 0.2}}},
         {"emissiveFactor", {0.25, 0.25, 0.25}}}};
    file.json()["meshes"][0]["primitives"][0]["material"] = 0;
    file.animate("/materials/0/pbrMetallicRoughness/baseColorFactor", 4,
                 {0, 0, 0, 0.5f, 1, 0.5f, 0, 1});
    file.animate("/materials/0/emissiveFactor", 3, {0.25f, 0.25f, 0.25f, 1, 2, 3}, "STEP");
    // Hermite with zero tangents: 0.2 to 0.6 is 0.2 + 0.4 (3 s^2 - 2 s^3).
    file.animate("/materials/0/pbrMetallicRoughness/roughnessFactor", 1, {0, 0.2f, 0, 0, 0.6f, 0},
                 "CUBICSPLINE");
    const Scene scene = file.scene();
    EXPECT_FALSE(warning(scene, "unsupportedExtension"));
    EXPECT_THAT(poseAt(scene, 0.0).materials, IsEmpty()) << "at rest nothing is changed";
    EXPECT_TRUE(bindMaterials(scene, poseAt(scene, 0.0), {}).own.empty());
    const Material quarter = materialAt(scene, 0.25);
    EXPECT_EQ(quarter.baseColor, glm::vec4(0.25f, 0.125f, 0.0f, 0.625f));
    EXPECT_EQ(quarter.emissive, glm::vec3(0.25f));
    EXPECT_NEAR(quarter.roughness, 0.2 + 0.4 * (3.0 / 16.0 - 2.0 / 64.0), 1e-6);
    const Material end = materialAt(scene, 1.0);
    EXPECT_EQ(end.baseColor, glm::vec4(1.0f, 0.5f, 0.0f, 1.0f));
    EXPECT_EQ(end.emissive, glm::vec3(1.0f, 2.0f, 3.0f));
    // An override wins, and a frame without clips has the file's materials.
    MaterialOverride dull{.material = "paint", .roughness = 0.75};
    const MaterialBindings both = bindMaterials(scene, poseAt(scene, 1.0), {dull});
    EXPECT_EQ(both.own.at(0).roughness, 0.75f);
    EXPECT_EQ(both.own.at(0).emissive, glm::vec3(1.0f, 2.0f, 3.0f));
    EXPECT_THAT(poseAt(scene, {}, 1.0).materials, IsEmpty());
    EXPECT_THAT(instancesThatChange(scene), ElementsAre(true));
    EXPECT_THAT(instancesThatMove(scene), ElementsAre(false));
    const Scene back = stored(scene);
    EXPECT_EQ(back.contentHash, scene.contentHash);
    EXPECT_EQ(poseAt(back, 0.25).materials.at(0).value, poseAt(scene, 0.25).materials.at(0).value);
}

TEST(AnimationPointers, FactorsStayInTheirRange) {
    PointerFile file;
    file.json()["materials"] = {{{"name", "paint"}}};
    file.json()["meshes"][0]["primitives"][0]["material"] = 0;
    file.animate("/materials/0/pbrMetallicRoughness/roughnessFactor", 1, {-3, 5});
    file.animate("/materials/0/pbrMetallicRoughness/baseColorFactor", 4,
                 {-1, 0, 0, -2, 2e6f, 2, 2, 9});
    const Scene scene = file.scene();
    EXPECT_EQ(materialAt(scene, 0.0).roughness, 0.0f);
    EXPECT_EQ(materialAt(scene, 1.0).roughness, 1.0f);
    EXPECT_EQ(materialAt(scene, 0.0).baseColor, glm::vec4(0.0f));
    EXPECT_EQ(materialAt(scene, 1.0).baseColor, glm::vec4(kMaxFactor, 2.0f, 2.0f, 1.0f));
}

TEST(AnimationPointers, LightsOfOneDefinitionChangeTogether) {
    PointerFile file;
    file.json()["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "spot"}, {"color", {1, 0.5, 0}}, {"intensity", 10}, {"range", 4}},
        {{"type", "point"}}};
    const auto lamp = [](int index) {
        json node;
        node["extensions"]["KHR_lights_punctual"]["light"] = index;
        return node;
    };
    file.json()["nodes"] = {{{"mesh", 0}}, lamp(0), lamp(1), lamp(0)};
    file.json()["scenes"][0]["nodes"] = {0, 1, 2, 3};
    const std::string light = "/extensions/KHR_lights_punctual/lights/0/";
    file.animate(light + "intensity", 1, {10, 30});
    file.animate(light + "color", 3, {1, 0.5f, 0, 0, 0.5f, 1});
    file.animate(light + "spot/innerConeAngle", 1, {0, 1.5f});
    const Scene scene = file.scene();
    ASSERT_EQ(scene.lights.size(), 3u);
    ASSERT_EQ(scene.clips.size(), 1u);
    EXPECT_EQ(scene.animatedLights.size(), 2u);
    EXPECT_EQ(lightsOf(scene, poseAt(scene, {}, 0.5))[0].intensity, glm::vec3(10, 5, 0));
    const Pose half = poseAt(scene, 0.5);
    for (const Index i : {0u, 2u}) {
        const Light& now = lightsOf(scene, half)[i];
        EXPECT_EQ(now.intensity, glm::vec3(10.0f, 10.0f, 10.0f)) << "20 times (0.5, 0.5, 0.5)";
        EXPECT_EQ(now.range, 4.0f);
        EXPECT_LE(now.innerConeAngle, now.outerConeAngle);
    }
    EXPECT_EQ(lightsOf(scene, half)[1].intensity, glm::vec3(1.0f));
    EXPECT_EQ(lightsWith(lightsOf(scene, half), {{.radius = 2.0}})[0].intensity, glm::vec3(10.0f));
}

TEST(AnimationPointers, CamerasZoom) {
    PointerFile file;
    file.json()["cameras"] = {
        {{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}}};
    file.json()["nodes"] = {{{"mesh", 0}}, {{"camera", 0}}};
    file.json()["scenes"][0]["nodes"] = {0, 1};
    file.animate("/cameras/0/perspective/yfov", 1, {0.5f, 1.0f});
    const Scene scene = file.scene();
    EXPECT_NEAR(camerasOf(scene, poseAt(scene, 0.5)).at(0).yfov, 0.75, 1e-6);
    EXPECT_NEAR(camerasOf(scene, restPose(scene)).at(0).yfov, 0.5, 1e-6);
}

TEST(AnimationPointers, NodePointersAreChannelsOfNodes) {
    PointerFile file;
    file.animate("/nodes/0/translation", 3, {0, 0, 0, 4, 0, 0});
    const Scene scene = file.scene();
    EXPECT_NEAR(poseAt(scene, 0.5).worldFromNode[0][3].x, 2.0, 1e-6);
}

TEST(AnimationPointers, WhatIsUnknownIsSkippedAndNamed) {
    PointerFile file;
    file.json()["materials"] = {{{"name", "paint"}}};
    file.animate("/materials/0/emissiveFactor", 3, {0, 0, 0, 1, 1, 1});
    file.animate("/materials/0/emissiveFactor", 3, {0, 0, 0, 2, 2, 2});  // a second time
    file.animate("/materials/0/emissiveFactor", 4, {0, 0, 0, 0, 1, 1, 1, 1});
    file.animate("/materials/9/emissiveFactor", 3, {0, 0, 0, 1, 1, 1});
    file.animate("/materials/1/emissiveFactor", 3, {0, 0, 0, 1, 1, 1});  // glTF's default
    file.animate("/materials/0/normalTexture/extensions/KHR_texture_transform/rotation", 1, {0, 1});
    file.animate("/cameras/0/perspective/yfov", 1, {0, 1});  // there is none
    file.animate("/nodes/0/extras/mood", 1, {0, 1});
    const Scene scene = file.scene();
    ASSERT_EQ(scene.clips.size(), 1u);
    EXPECT_EQ(scene.clips[0].tracks.size(), 1u);
    ASSERT_TRUE(warning(scene, "unsupportedAnimation"));
    EXPECT_EQ(warning(scene, "unsupportedAnimation")->subject, "/nodes/0/extras/mood");
    ASSERT_TRUE(warning(scene, "badAnimation"));
    EXPECT_EQ(warning(scene, "badAnimation")->count, 6u);
}

TEST(NodeVisibility, HidesMeshesAndLightsBelow) {
    PointerFile file;
    file.json()["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
    json hidden{{"children", {2}}, {"camera", 0}};
    hidden["extensions"]["KHR_node_visibility"]["visible"] = false;
    json below{{"mesh", 0}};
    below["extensions"]["KHR_lights_punctual"]["light"] = 0;
    below["extensions"]["KHR_node_visibility"]["visible"] = true;
    file.json()["cameras"] = {
        {{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}}};
    file.json()["nodes"] = {{{"mesh", 0}}, hidden, below};
    file.json()["scenes"][0]["nodes"] = {0, 1};
    const Scene scene = file.scene();
    EXPECT_EQ(scene.instances.size(), 1u);
    EXPECT_EQ(scene.lights.size(), 0u);
    EXPECT_EQ(scene.cameras.size(), 1u) << "cameras are not seen";
    EXPECT_TRUE(restPose(scene).hidden.empty());
}

TEST(NodeVisibility, ClipsShowAndHide) {
    PointerFile file;
    file.json()["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
    json lamp{{"mesh", 0}};
    lamp["extensions"]["KHR_lights_punctual"]["light"] = 0;
    json blinking{{"children", {2}}};
    blinking["extensions"]["KHR_node_visibility"]["visible"] = false;
    file.json()["nodes"] = {{{"mesh", 0}}, blinking, lamp};
    file.json()["scenes"][0]["nodes"] = {0, 1};
    file.show(1, {0, 1, 0});
    const Scene scene = file.scene();
    ASSERT_EQ(scene.instances.size(), 2u);
    const auto hiddenAt = [&](double time) { return poseAt(scene, time).hidden; };
    EXPECT_THAT(hiddenAt(0.5), ElementsAre(false, true));
    EXPECT_THAT(hiddenAt(1.5), IsEmpty());
    EXPECT_THAT(hiddenAt(2.0), ElementsAre(false, true));
    EXPECT_THAT(restPose(scene).hidden, ElementsAre(false, true));
    EXPECT_EQ(lightsOf(scene, poseAt(scene, 0.5)).at(0).intensity, glm::vec3(0.0f));
    EXPECT_EQ(lightsOf(scene, poseAt(scene, 1.5)).at(0).intensity, glm::vec3(1.0f));
    EXPECT_THAT(instancesThatMove(scene), ElementsAre(false, true));
    EXPECT_THAT(poseAt(stored(scene), 0.5).hidden, ElementsAre(false, true));
}

}  // namespace
}  // namespace clerestory::test
