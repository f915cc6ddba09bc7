// Layers of glTF materials: every property and texture arrives, and values out of range are
// clamped.
#include "import_support.h"
#include "tests/support/scene_files.h"

#include "image/image.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace clerestory::test {
namespace {

using nlohmann::json;

Scene withMaterial(const json& extensions) {
    const TemporaryFolder folder;
    Image image{.width = 1, .height = 1, .channels = 4};
    image.data.assign(4, std::byte{128});
    folder.write("grey.png", encodePng(image));
    json document = json::parse(triangleGltf());
    document["images"] = {{{"uri", "grey.png"}}};
    document["textures"] = {{{"source", 0}}};
    document["materials"] = {{{"name", "layered"}, {"extensions", extensions}}};
    for (json& mesh : document["meshes"]) {
        for (json& primitive : mesh["primitives"]) primitive["material"] = 0;
    }
    return importScene(folder.write("scene.gltf", document.dump()));
}

const json kTexture = {{"index", 0}};

TEST(GltfLayers, KeepEveryProperty) {
    const Scene scene =
        withMaterial({{"KHR_materials_clearcoat",
                       {{"clearcoatFactor", 0.5},
                        {"clearcoatTexture", kTexture},
                        {"clearcoatRoughnessFactor", 0.25},
                        {"clearcoatRoughnessTexture", kTexture},
                        {"clearcoatNormalTexture", {{"index", 0}, {"scale", 0.75}}}}},
                      {"KHR_materials_sheen",
                       {{"sheenColorFactor", {0.5, 0.25, 1.0}},
                        {"sheenColorTexture", kTexture},
                        {"sheenRoughnessFactor", 0.5},
                        {"sheenRoughnessTexture", kTexture}}},
                      {"KHR_materials_iridescence",
                       {{"iridescenceFactor", 1.0},
                        {"iridescenceTexture", kTexture},
                        {"iridescenceIor", 1.5},
                        {"iridescenceThicknessMinimum", 200.0},
                        {"iridescenceThicknessMaximum", 800.0},
                        {"iridescenceThicknessTexture", kTexture}}},
                      {"KHR_materials_anisotropy",
                       {{"anisotropyStrength", 0.5},
                        {"anisotropyRotation", 0.25},
                        {"anisotropyTexture", kTexture}}},
                      {"KHR_materials_diffuse_transmission",
                       {{"diffuseTransmissionFactor", 0.5},
                        {"diffuseTransmissionTexture", kTexture},
                        {"diffuseTransmissionColorFactor", {0.5, 1.0, 0.25}},
                        {"diffuseTransmissionColorTexture", kTexture}}},
                      {"KHR_materials_dispersion", {{"dispersion", 0.5}}},
                      {"KHR_materials_specular",
                       {{"specularTexture", kTexture}, {"specularColorTexture", kTexture}}}});
    EXPECT_EQ(warning(scene, "unsupportedTexture"), nullptr);
    const Material& m = *material(scene, "layered");
    EXPECT_EQ(m.clearcoat, 0.5f);
    EXPECT_EQ(m.clearcoatRoughness, 0.25f);
    EXPECT_EQ(m.clearcoatNormalScale, 0.75f);
    EXPECT_EQ(m.sheenColor, glm::vec3(0.5f, 0.25f, 1.0f));
    EXPECT_EQ(m.sheenRoughness, 0.5f);
    EXPECT_EQ(m.iridescence, 1.0f);
    EXPECT_EQ(m.iridescenceIor, 1.5f);
    EXPECT_EQ(m.iridescenceThicknessMin, 200.0f);
    EXPECT_EQ(m.iridescenceThickness, 800.0f);
    EXPECT_EQ(m.anisotropy, 0.5f);
    EXPECT_EQ(m.anisotropyRotation, 0.25f);
    EXPECT_EQ(m.diffuseTransmission, 0.5f);
    EXPECT_EQ(m.diffuseTransmissionColor, glm::vec3(0.5f, 1.0f, 0.25f));
    EXPECT_EQ(m.dispersion, 0.5f);
    const auto spaceOf = [&](const TextureSlot& slot) {
        return scene.images.at(scene.textures.at(slot.texture).image).colorSpace;
    };
    for (const TextureSlot* slot :
         {&m.clearcoatTexture, &m.clearcoatRoughnessTexture, &m.clearcoatNormalTexture,
          &m.sheenRoughnessTexture, &m.iridescenceTexture, &m.iridescenceThicknessTexture,
          &m.anisotropyTexture, &m.diffuseTransmissionTexture, &m.specularTexture}) {
        EXPECT_EQ(spaceOf(*slot), ColorSpace::linear);
    }
    for (const TextureSlot* slot :
         {&m.sheenColorTexture, &m.diffuseTransmissionColorTexture, &m.specularColorTexture}) {
        EXPECT_EQ(spaceOf(*slot), ColorSpace::srgb);
    }
}

TEST(GltfLayers, ValuesOutOfRangeAreClampedWithAWarning) {
    const Scene scene = withMaterial(
        {{"KHR_materials_clearcoat", {{"clearcoatFactor", 7}, {"clearcoatRoughnessFactor", -1}}},
         {"KHR_materials_iridescence", {{"iridescenceFactor", 2}, {"iridescenceIor", 0.1}}},
         {"KHR_materials_dispersion", {{"dispersion", 1e9}}}});
    EXPECT_NE(warning(scene, "materialOutOfRange"), nullptr);
    const Material& m = *material(scene, "layered");
    EXPECT_EQ(m.clearcoat, 1.0f);
    EXPECT_EQ(m.clearcoatRoughness, 0.0f);
    EXPECT_EQ(m.iridescence, 1.0f);
    EXPECT_GE(m.iridescenceIor, 1.0f);
    EXPECT_LE(m.dispersion, 20.0f);
    EXPECT_TRUE(sceneProblems(scene).empty());
}

// One image as the normal map of base and coat stays a normal map: it is not joined with numbers
// that only the base reads.
TEST(GltfLayers, AMapOfBaseAndCoatIsNotPacked) {
    const TemporaryFolder folder;
    Image image{.width = 2, .height = 2, .channels = 4};
    image.data.assign(16, std::byte{128});
    folder.write("normal.png", encodePng(image));
    folder.write("numbers.png", encodePng(image));
    json document = json::parse(triangleGltf());
    document["images"] = {{{"uri", "normal.png"}}, {{"uri", "numbers.png"}}};
    document["textures"] = {{{"source", 0}}, {{"source", 1}}};
    json m = {{"name", "layered"},
              {"normalTexture", {{"index", 0}}},
              {"pbrMetallicRoughness", {{"metallicRoughnessTexture", {{"index", 1}}}}}};
    for (const bool shared : {false, true}) {
        if (shared) {
            m["extensions"] = {
                {"KHR_materials_clearcoat",
                 {{"clearcoatFactor", 1}, {"clearcoatNormalTexture", {{"index", 0}}}}}};
        }
        document["materials"] = {m};
        for (json& mesh : document["meshes"]) {
            for (json& primitive : mesh["primitives"]) primitive["material"] = 0;
        }
        const Scene scene = importScene(folder.write("scene.gltf", document.dump()));
        const Index texture = material(scene, "layered")->normalTexture.texture;
        EXPECT_EQ(scene.images[scene.textures[texture].image].packedNormal, !shared);
    }
}

}  // namespace
}  // namespace clerestory::test
