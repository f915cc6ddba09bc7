// OBJ and MTL converted to glTF's properties.
#include "tests/unit/import_support.h"

#include "scene/classification.h"

#include <cmath>

namespace clerestory {
namespace {

const Scene& materials() {
    static const Scene scene = importSceneInProcess(ownScene("materials.obj"));
    return scene;
}

TEST(Obj, SeparateIndicesShareVertices) {
    // The third corner of the first triangle: position 3, texture coordinate 3, normal 1.
    bool found = false;
    for (const Vertex& v : materials().vertices) {
        found |= v.position == glm::vec3(1, 1, 0) && v.texCoord0 == glm::vec2(0, 0) &&
                 v.normal == glm::vec3(0, 0, 1);
    }
    EXPECT_TRUE(found) << "v counts downwards in glTF, so OBJ's 1 is 0";
    EXPECT_EQ(triangleCount(materials()), 8u) << "the four-cornered face is two";
}

TEST(Obj, GlassTransmits) {
    const Material& glass = *material(materials(), "glass");
    EXPECT_NEAR(glass.transmission, 0.9f, 1e-6f);
    EXPECT_EQ(glass.ior, 1.5f);
    EXPECT_EQ(glass.roughness, 0.0f);
    EXPECT_EQ(glass.alphaMode, AlphaMode::opaque);
    EXPECT_EQ(glass.baseColor, glm::vec4(0.5f, 1.0f, 1.0f, 1.0f))
        << "tinted by Tf, not by black Kd";
    const Material& tinted = *material(materials(), "tinted");
    EXPECT_EQ(tinted.transmission, 0.5f) << "an index of refraction is enough";
    EXPECT_EQ(tinted.ior, 1.31f);
}

TEST(Obj, ThinPanesBlend) {
    const Material& pane = *material(materials(), "pane");
    EXPECT_EQ(pane.transmission, 0.0f);
    EXPECT_EQ(pane.alphaMode, AlphaMode::blend);
    EXPECT_EQ(pane.baseColor, glm::vec4(0.2f, 0.4f, 0.6f, 0.25f));
}

TEST(Obj, MirrorsAreMetal) {
    const Material& mirror = *material(materials(), "mirror");
    EXPECT_EQ(mirror.metallic, 1.0f);
    EXPECT_EQ(mirror.roughness, 0.0f);
    EXPECT_EQ(mirror.baseColor, glm::vec4(0.9f, 0.8f, 0.7f, 1.0f));
}

struct MtlRow {
    const char* name;
    const char* mtl;
    Reflector flat;
    Glass glass;
};
class Mtl : public testing::TestWithParam<MtlRow> {};

TEST_P(Mtl, IsClassifiedByItsKeywords) {
    const TemporaryFolder folder;
    folder.write("m.mtl", std::string("newmtl m\n") + GetParam().mtl);
    const Scene scene = importSceneInProcess(
        folder.write("m.obj",
                     "mtllib m.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\n"
                     "v 1 0 1\nv 1 1 1\nv 0 1 1\nf 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\n"
                     "f 2 3 7 6\nf 4 1 5 8\n"));
    const Surface first = surfacesOf(scene).at(0);
    EXPECT_EQ(first.reflector, GetParam().flat) << reflectorReason(scene, {}, first);
    EXPECT_EQ(first.glass, GetParam().glass) << glassReason(scene, {}, first);
    if (first.glass == Glass::solid) {
        EXPECT_EQ(scene.materials.at(scene.instances[0].material).thickness, 1.0f);
    }
}

INSTANTIATE_TEST_SUITE_P(
    Words, Mtl,
    testing::Values(
        MtlRow{"matte", "Kd .5 .5 .5\nillum 1\n", Reflector::none, Glass::none},
        MtlRow{"shiny", "Kd .5 .5 .5\nKs .9 .9 .9\nNs 20\nillum 2\n", Reflector::none, Glass::none},
        MtlRow{"mirrorOfMetal", "Kd 0 0 0\nKs .9 .9 .9\nillum 3\n", Reflector::flat, Glass::none},
        MtlRow{"tracedFloor", "Kd .5 .5 .5\nKs .9 .9 .9\nNs 20\nillum 3\n", Reflector::flat,
               Glass::none},
        MtlRow{"tracedButMatte", "Kd .5 .5 .5\nKs 0 0 0\nillum 3\n", Reflector::none, Glass::none},
        MtlRow{"glassBall", "Kd 0 0 0\nKs 1 1 1\nNi 1.5\nd 0.1\nillum 7\n", Reflector::flat,
               Glass::solid},
        MtlRow{"glassWithoutOpacity", "Kd 0 0 0\nKs 1 1 1\nNi 1.5\nillum 7\n", Reflector::flat,
               Glass::solid},
        MtlRow{"glassOnForEverything", "Kd .5 .5 .5\nTf 1 1 1\nillum 4\n", Reflector::none,
               Glass::none},
        MtlRow{"indexAlone", "Kd .5 .5 .5\nNi 1.33\nd 0.5\nillum 2\n", Reflector::flat,
               Glass::solid},
        MtlRow{"thinGlass", "Kd .5 .5 .5\nd 0.5\nillum 9\n", Reflector::flat, Glass::pane},
        MtlRow{"coverage", "Kd .5 .5 .5\nd 0.5\nillum 2\n", Reflector::none, Glass::none}),
    [](const auto& row) { return row.param.name; });

TEST(Obj, HighlightsBecomeRoughness) {
    // alpha = sqrt(2 / (98 + 2)), roughness = sqrt(alpha)
    const Material& painted = *material(materials(), "painted");
    EXPECT_NEAR(painted.roughness, std::sqrt(std::sqrt(0.02f)), 1e-6f);
    ASSERT_TRUE(painted.baseColorTexture.present());
    EXPECT_EQ(materials().images.at(0).name, "four colours.png");
    EXPECT_EQ(painted.alphaMode, AlphaMode::opaque)
        << "a picture's alpha is not coverage by itself";
}

TEST(Obj, OpacityMapsCutOut) {
    const Material& leaf = *material(materials(), "leaf");
    EXPECT_EQ(leaf.alphaMode, AlphaMode::mask);
    ASSERT_TRUE(leaf.baseColorTexture.present());
    const TextureImage& image =
        materials().images.at(materials().textures.at(leaf.baseColorTexture.texture).image);
    // The left half of leaf.png is white, the right half black.
    const std::vector<std::uint8_t> topRow(image.texels.begin(), image.texels.begin() + 8);
    EXPECT_EQ(topRow, (std::vector<std::uint8_t>{255, 0, 0, 255, 0, 255, 0, 0}));
}

// Erratum E1: emission is Ke, independent of Kd.
TEST(Obj, EmissionIsKeIndependentOfKd) {
    EXPECT_EQ(material(materials(), "lamp")->emissive, glm::vec3(12.5f, 0.0f, 3.0f));

    const char* const values[] = {"0", "1e-6", "0.5", "1"};
    const float numbers[] = {0.0f, 1e-6f, 0.5f, 1.0f};
    std::string mtl;
    std::string obj = "mtllib all.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (int i = 0; i < 64; ++i) {
        const std::string name = "m" + std::to_string(i);
        const std::string ke =
            std::string(values[i % 4]) + " " + values[i / 4 % 4] + " " + values[i / 16];
        const std::string kd =
            std::string(values[i / 16]) + " " + values[i % 4] + " " + values[i / 4 % 4];
        mtl += "newmtl " + name + "\nKd " + kd + "\nKe " + ke + "\n";
        obj += "usemtl " + name + "\nf 1 2 3\n";
    }
    const TemporaryFolder folder;
    folder.write("all.mtl", mtl);
    const Scene scene = importSceneInProcess(folder.write("all.obj", obj));
    for (int i = 0; i < 64; ++i) {
        const Material& m = *material(scene, "m" + std::to_string(i));
        const glm::vec3 expected(numbers[i % 4], numbers[i / 4 % 4], numbers[i / 16]);
        for (int c = 0; c < 3; ++c) {
            // Assimp's number reader is a few units in the last place off.
            EXPECT_NEAR(emittedRadiance(m)[c], expected[c], 1e-6f * expected[c]) << i;
        }
    }
}

// Erratum G6: how many channels a file stores says nothing of the surface. One picture, in 24 and
// in 32 bits a texel (TGA, uncompressed, 2 x 2).
TEST(Obj, AnOpaqueAlphaChannelChangesNothing) {
    const auto imported = [](int channels) {
        std::string tga(18, '\0');
        tga[2] = 2;
        tga[12] = tga[14] = 2;
        tga[16] = static_cast<char>(8 * channels);
        for (int texel = 0; texel < 4; ++texel) {
            for (int c = 0; c < channels; ++c) {
                tga += c == 3 ? '\xff' : static_cast<char>(40 * texel + 9 * c);
            }
        }
        const TemporaryFolder folder;
        folder.write("wall.tga", tga);
        folder.write("wall.mtl", "newmtl wall\nKd 1 1 1\nmap_Kd wall.tga\n");
        return importSceneInProcess(
            folder.write("wall.obj",
                         "mtllib wall.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
                         "usemtl wall\nf 1/1 2/2 3/3\n"));
    };
    const Scene three = imported(3), four = imported(4);
    ASSERT_EQ(three.images.size(), 1u);
    ASSERT_EQ(four.images.size(), 1u);
    EXPECT_EQ(three.images[0].texels, four.images[0].texels);
    EXPECT_EQ(three.contentHash, four.contentHash);
    for (const Scene* scene : {&three, &four}) {
        EXPECT_EQ(material(*scene, "wall")->alphaMode, AlphaMode::opaque);
        EXPECT_EQ(material(*scene, "wall")->transmission, 0.0f);
    }
}

TEST(Obj, EdgesWithoutNormalsStaySharp) {
    const TemporaryFolder folder;
    const Scene scene = importSceneInProcess(folder.write("roof.obj",
                                                          "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
                                                          "f 1 3 2\nf 1 2 4\n"));
    for (const Vertex& v : scene.vertices) {
        const glm::vec3 a = glm::abs(v.normal);
        EXPECT_NEAR(std::max({a.x, a.y, a.z}), 1.0f, 1e-6f) << "a right angle is not smoothed";
    }
}

}  // namespace
}  // namespace clerestory
