// KHR_materials_pbrSpecularGlossiness: the conversion inverts the definitions of both models, and
// images are converted texel by texel.
#include "import_support.h"
#include "tests/support/scene_files.h"

#include "image/image.h"
#include "scene/import/textures/specular_glossiness.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include <random>

namespace clerestory::test {
namespace {

using nlohmann::json;

// A mixture of a dielectric and a metal has the diffuse and specular colours of its parts.
TEST(SpecularGlossiness, ConversionInvertsTheDefinitions) {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> share(0.05f, 0.95f);
    for (int i = 0; i < 2000; ++i) {
        // Grey: the brightness of a mixture is then the mixture of the brightnesses.
        const glm::vec3 base(share(random));
        const float metallic = i % 3 == 0 ? 0.0f : i % 3 == 1 ? 1.0f : share(random);
        const glm::vec3 specular = glm::mix(glm::vec3(0.04f), base, metallic);
        const float remaining = 1.0f - specular.x;
        const glm::vec3 diffuse = base * (0.96f * (1.0f - metallic) / remaining);
        const MetallicBase found = metallicBase(diffuse, specular);
        EXPECT_NEAR(found.metallic, metallic, 2e-3f) << base.x;
        EXPECT_NEAR(found.color.x, base.x, 5e-3f) << metallic;
    }
    const MetallicBase gold = metallicBase(glm::vec3(0.0f), {0.9f, 0.6f, 0.2f});
    EXPECT_FLOAT_EQ(gold.metallic, 1.0f);
    EXPECT_NEAR(glm::distance(gold.color, {0.9f, 0.6f, 0.2f}), 0.0f, 1e-6f);
    const MetallicBase plastic = metallicBase({0.7f, 0.1f, 0.2f}, glm::vec3(0.04f));
    EXPECT_FLOAT_EQ(plastic.metallic, 0.0f);
    EXPECT_NEAR(glm::distance(plastic.color, {0.7f, 0.1f, 0.2f}), 0.0f, 1e-6f);
}

TEST(SpecularGlossiness, AnythingGivesColoursInRange) {
    std::mt19937 random(2);
    std::uniform_real_distribution<float> any(0.0f, 1.0f);
    for (int i = 0; i < 20000; ++i) {
        const auto color = [&] {
            return glm::round(4.0f * glm::vec3(any(random), any(random), any(random))) / 4.0f;
        };
        const MetallicBase found = metallicBase(color(), color());
        EXPECT_TRUE(found.metallic >= 0.0f && found.metallic <= 1.0f);
        for (int k = 0; k < 3; ++k) {
            EXPECT_TRUE(found.color[k] >= 0.0f && found.color[k] <= 1.0f);
        }
    }
}

// Two texels of paint and two of gold; the alpha of the diffuse image is kept.
TEST(SpecularGlossiness, TexturesAreConvertedTexelByTexel) {
    const TemporaryFolder folder;
    const auto png = [&](const char* name, const std::vector<std::uint8_t>& rgba) {
        Image image{.width = 2, .height = 2, .channels = 4};
        for (const std::uint8_t code : rgba) image.data.push_back(std::byte{code});
        const std::string bytes = encodePng(image);
        folder.write(name, bytes);
    };
    png("diffuse.png", {200, 20, 40, 255, 0, 0, 0, 255, 200, 20, 40, 99, 0, 0, 0, 99});
    png("specular.png", {56, 56, 56, 255, 255, 200, 100, 255, 56, 56, 56, 0, 255, 200, 100, 51});
    json document = json::parse(triangleGltf());
    document["images"] = {{{"uri", "diffuse.png"}}, {{"uri", "specular.png"}}};
    document["textures"] = {{{"source", 0}}, {{"source", 1}}};
    document["materials"] = {{{"name", "bottle"},
                              {"extensions",
                               {{"KHR_materials_pbrSpecularGlossiness",
                                 {{"diffuseTexture", {{"index", 0}}},
                                  {"diffuseFactor", {1, 1, 1, 0.5}},
                                  {"specularGlossinessTexture", {{"index", 1}}},
                                  {"glossinessFactor", 0.5}}}}}}};
    for (json& mesh : document["meshes"]) {
        for (json& primitive : mesh["primitives"]) primitive["material"] = 0;
    }
    const auto file = folder.write("scene.gltf", document.dump());
    const Scene scene = importScene(file);
    EXPECT_FALSE(warning(scene, "missingTexture") || warning(scene, "unsupportedTexture"));
    const Material& m = *material(scene, "bottle");
    EXPECT_EQ(m.baseColor, glm::vec4(1.0f, 1.0f, 1.0f, 0.5f));
    EXPECT_EQ(m.metallic, 1.0f);
    EXPECT_EQ(m.roughness, 1.0f);
    const auto texels = [&](const TextureSlot& slot) {
        const TextureImage& image = scene.images[scene.textures[slot.texture].image];
        return std::vector<int>(image.texels.begin(), image.texels.begin() + 16);
    };
    // The code 56 is a reflectance of 0.0395.
    const std::vector<int> base = texels(m.baseColorTexture);
    const std::vector<int> paint{200, 20, 40}, gold{255, 200, 100};
    for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(base[k], paint[k], 1);
        EXPECT_EQ(base[4 + k], gold[k]);
    }
    EXPECT_EQ(base[3], 255);
    EXPECT_EQ(base[11], 99);
    const std::vector<int> surface = texels(m.metallicRoughnessTexture);
    EXPECT_EQ(surface[2], 0);
    EXPECT_EQ(surface[4 + 2], 255);
    EXPECT_EQ(surface[1], 128) << "glossiness 0.5 of 1";
    EXPECT_EQ(surface[8 + 1], 255) << "of 0";
    EXPECT_EQ(surface[12 + 1], 230) << "of 0.2";
    // Without the second image, the first one is shown as a dielectric of white reflectance: all of
    // the light is specular then, which the default factor says.
    std::filesystem::remove(folder / "specular.png");
    const Scene without = importScene(file);
    EXPECT_TRUE(warning(without, "missingTexture"));
    EXPECT_TRUE(material(without, "bottle")->baseColorTexture.present());
}

}  // namespace
}  // namespace clerestory::test
