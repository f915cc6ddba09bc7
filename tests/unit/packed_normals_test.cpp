// Packing metallic-roughness maps into normal maps: which are packed, and the precision of the
// result.
#include "scene/normal_maps.h"
#include "scene/texture_images.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

using namespace clerestory;

namespace {

Index addPicture(Scene& scene, std::uint32_t edge, std::uint8_t seed,
                 ColorSpace space = ColorSpace::linear) {
    TextureImage image{.width = edge, .height = edge, .colorSpace = space};
    for (std::uint32_t i = 0; i < edge * edge; ++i) {
        const auto at = [&](std::uint32_t step) {
            return static_cast<std::uint8_t>(60 + (seed + i * step) % 130);
        };
        const std::uint8_t blue = static_cast<std::uint8_t>(140 + (seed + i * 7) % 110);
        image.texels.insert(image.texels.end(), {at(13), at(29), blue, 255});
    }
    buildLevels(image);
    scene.images.push_back(std::move(image));
    scene.textures.push_back({.image = static_cast<Index>(scene.images.size() - 1)});
    return static_cast<Index>(scene.textures.size() - 1);
}

// Colours, normals and metallic-roughness of one material, in this order.
Scene pairOf(std::uint32_t normalEdge = 8) {
    Scene scene;
    Material m;
    m.baseColorTexture.texture = addPicture(scene, 8, 1, ColorSpace::srgb);
    m.normalTexture.texture = addPicture(scene, normalEdge, 5);
    m.metallicRoughnessTexture.texture = addPicture(scene, 8, 90);
    scene.materials.push_back(m);
    return scene;
}

glm::dvec3 directionOf(const std::uint8_t* rgba) {
    const glm::dvec3 v(2.0 * rgba[0] - 255.0, 2.0 * rgba[1] - 255.0, 2.0 * rgba[2] - 255.0);
    return glm::normalize(v);
}

}  // namespace

TEST(PackedNormals, StoreDirectionsWithMetallicAndRoughness) {
    const Scene before = pairOf();
    Scene after = before;
    packNormals(after);
    ASSERT_EQ(after.images.size(), 2u);
    EXPECT_FALSE(after.images[0].packedNormal);
    ASSERT_TRUE(after.images[1].packedNormal);
    ASSERT_EQ(after.textures.size(), 2u);
    EXPECT_EQ(after.textures[1].image, 1u);
    EXPECT_EQ(after.materials[0].normalTexture.texture, 1u);
    EXPECT_EQ(after.materials[0].metallicRoughnessTexture, after.materials[0].normalTexture);
    EXPECT_EQ(after.images[1].mean.g, before.images[2].mean.g);

    const auto &normals = before.images[1].texels, &numbers = before.images[2].texels,
               &joined = after.images[1].texels;
    ASSERT_EQ(joined.size(), numbers.size());
    for (std::size_t i = 0; i < joined.size(); i += 4) {
        EXPECT_EQ(joined[i + 1], numbers[i + 1]);
        EXPECT_EQ(joined[i + 2], numbers[i + 2]);
        const glm::dvec3 expected = directionOf(&normals[i]);
        const double x = joined[i] / 127.5 - 1.0, y = joined[i + 3] / 127.5 - 1.0;
        EXPECT_NEAR(x, expected.x, 0.5 / 127.5 + 1e-6);  // half a code
        EXPECT_NEAR(y, expected.y, 0.5 / 127.5 + 1e-6);
    }
}

TEST(PackedNormals, NegativeZIsClampedToZero) {
    Scene scene = pairOf();
    scene.images[1].texels[0] = 255;
    scene.images[1].texels[1] = 128;
    scene.images[1].texels[2] = 0;
    packNormals(scene);
    EXPECT_EQ(scene.images[1].texels[0], 255);
    EXPECT_EQ(scene.images[1].texels[3], 128);
}

TEST(PackedNormals, DifferentlySampledTexturesAreNotPacked) {
    struct Case {
        std::string name;
        std::function<void(Scene&)> change;
    };
    const std::array<Case, 9> cases{{
        {"another size", [](Scene& s) { s = pairOf(4); }},
        {"moved", [](Scene& s) { s.materials[0].normalTexture.offset.x = 0.5f; }},
        {"the other set", [](Scene& s) { s.materials[0].normalTexture.texCoord = 1; }},
        {"another sampling", [](Scene& s) { s.textures[1].wrapU = Wrap::clampToEdge; }},
        {"colours", [](Scene& s) { s.images[2].colorSpace = ColorSpace::srgb; }},
        {"the normal map as colour",
         [](Scene& s) {
             s.materials.push_back({});
             s.materials[1].baseColorTexture = s.materials[0].normalTexture;
         }},
        {"one picture for both",
         [](Scene& s) { s.materials[0].metallicRoughnessTexture = s.materials[0].normalTexture; }},
        {"normals without the others",
         [](Scene& s) {
             s.materials.push_back({});
             s.materials[1].normalTexture = s.materials[0].normalTexture;
         }},
        {"two others for one normal map",
         [](Scene& s) {
             s.materials.push_back(s.materials[0]);
             s.materials[1].metallicRoughnessTexture.texture = addPicture(s, 8, 33);
         }},
    }};
    for (const Case& c : cases) {
        Scene scene = pairOf();
        c.change(scene);
        const std::size_t images = scene.images.size();
        packNormals(scene);
        EXPECT_EQ(scene.images.size(), images) << c.name;
        for (const TextureImage& image : scene.images) EXPECT_FALSE(image.packedNormal) << c.name;
    }
}

TEST(PackedNormals, SharedTexturesAreKept) {
    Scene scene = pairOf();
    scene.materials[0].occlusionTexture = scene.materials[0].metallicRoughnessTexture;
    scene.materials.push_back({});
    scene.materials[1].metallicRoughnessTexture = scene.materials[0].metallicRoughnessTexture;
    const std::vector<std::uint8_t> numbers = scene.images[2].texels;
    packNormals(scene);
    ASSERT_EQ(scene.images.size(), 3u);
    EXPECT_TRUE(scene.images[1].packedNormal);
    EXPECT_EQ(scene.images[2].texels, numbers);
    EXPECT_EQ(scene.materials[0].occlusionTexture.texture, 2u);
    EXPECT_EQ(scene.materials[1].metallicRoughnessTexture.texture, 2u);
}

TEST(PackedNormals, OneTextureServesSeveralNormalMaps) {
    Scene scene = pairOf();
    scene.materials.push_back(scene.materials[0]);  // reads the same two
    scene.materials.push_back(scene.materials[0]);
    scene.materials[2].normalTexture.texture = addPicture(scene, 8, 9);
    packNormals(scene);
    ASSERT_EQ(scene.images.size(), 3u);
    EXPECT_TRUE(scene.images[1].packedNormal && scene.images[2].packedNormal);
    for (const Material& m : scene.materials) {
        EXPECT_EQ(m.metallicRoughnessTexture, m.normalTexture);
    }
    EXPECT_EQ(scene.textures[scene.materials[0].normalTexture.texture].image, 1u);
    EXPECT_EQ(scene.textures[scene.materials[1].normalTexture.texture].image, 1u);
    EXPECT_EQ(scene.textures[scene.materials[2].normalTexture.texture].image, 2u);
}
