// Material properties: coverage, sidedness, textures.
#include "scene/normal_maps.h"
#include "support.h"

#include <cmath>

using namespace clerestory;
using namespace clerestory::test;

namespace {

class Materials : public GlTest {};

const glm::vec3 kRed(1, 0, 0), kGreen(0, 1, 0), kBlue(0, 0, 1), kWhite(1), kNothing(0);
const std::array<glm::u8vec4, 4> kFourColors = {
    glm::u8vec4(255, 0, 0, 255), {0, 255, 0, 255}, {0, 0, 255, 255}, {255, 255, 255, 255}};

// A quad whose texture coordinates run from 0 to `repeats`.
MeshDraft repeated(float half, Index material, float repeats) {
    MeshDraft draft = quad(half, material);
    for (Vertex& v : draft.vertices) v.texCoord0 *= repeats;
    return draft;
}

}  // namespace

TEST_F(Materials, UnlitMaterialsShowTheirExactColour) {
    Scene scene;
    place(scene, quad(1.0f, addMaterial(scene, unlit({0.25f, 0.5f, 0.75f, 1}))));
    FrameRequest r = request(std::move(scene), "unlit");
    r.environment.map = "sky";
    EXPECT_EQ(centerColor(renderer().render(r).image), glm::vec3(0.25f, 0.5f, 0.75f));
}

TEST_F(Materials, MasksAreCutBelowTheirCutoff) {
    Scene scene;
    Material m = unlit(glm::vec4(1));
    m.alphaMode = AlphaMode::mask;
    m.alphaCutoff = 0.5f;
    m.baseColorTexture.texture = addTexture2x2(scene,
                                               {glm::u8vec4(255, 255, 255, 0),
                                                {255, 255, 255, 127},
                                                {255, 255, 255, 128},
                                                {255, 255, 255, 255}},
                                               Wrap::clampToEdge);
    place(scene, quad(1.0f, addMaterial(scene, m)));
    place(scene, quad(1.0f, addMaterial(scene, unlit({0, 0, 1, 1}))), moved(0, 0, -0.01));
    const Image image = renderer().render(request(std::move(scene), "mask")).image;
    EXPECT_EQ(color(image, 24, 24), kBlue);
    EXPECT_EQ(color(image, 40, 24), kBlue);
    EXPECT_EQ(color(image, 24, 40), kWhite);
    EXPECT_EQ(color(image, 40, 40), kWhite);
}

TEST_F(Materials, BlendedSurfacesAreComposedFarToNear) {
    Scene scene;
    Material red = unlit({1, 0, 0, 0.5f}), green = unlit({0, 1, 0, 0.25f});
    red.alphaMode = green.alphaMode = AlphaMode::blend;
    // The nearest first in the scene: order must come from distance.
    place(scene, quad(1.0f, addMaterial(scene, green)), moved(0, 0, 0.5));
    place(scene, quad(1.0f, addMaterial(scene, red)), moved(0, 0, 0.25));
    place(scene, quad(1.0f, addMaterial(scene, unlit({0, 0, 1, 1}))));
    const Image image = renderer().render(request(std::move(scene), "blend")).image;
    // 0.25 green over (0.5 red over blue)
    const glm::vec3 expected = 0.25f * kGreen + 0.75f * (0.5f * kRed + 0.5f * kBlue);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(centerColor(image)[c], expected[c], 1e-6f);
}

TEST_F(Materials, BlendedSurfacesHideBehindOpaqueOnes) {
    Scene scene;
    Material red = unlit({1, 0, 0, 0.5f});
    red.alphaMode = AlphaMode::blend;
    place(scene, quad(1.0f, addMaterial(scene, red)), moved(0, 0, -1));
    place(scene, quad(1.0f, addMaterial(scene, unlit({0, 0, 1, 1}))));
    EXPECT_EQ(centerColor(renderer().render(request(std::move(scene), "hidden")).image), kBlue);
}

TEST_F(Materials, SingleSidedBacksAreNotDrawnAndDoubleSidedOnesAre) {
    glm::dmat4 turned(1.0);  // half a turn about Y
    turned[0][0] = turned[2][2] = -1.0;
    glm::dmat4 mirrored(1.0);  // along X: faces the same way, determinant below 0
    mirrored[0][0] = -1.0;
    const glm::dmat4 mirroredAway = turned * mirrored;
    struct Row {
        const char* name;
        glm::dmat4 worldFromModel;
        bool doubleSided, seen;
    };
    for (const Row& row :
         {Row{"front", glm::dmat4(1.0), false, true}, Row{"back", turned, false, false},
          Row{"mirrored front", mirrored, false, true},
          Row{"mirrored back", mirroredAway, false, false},
          Row{"double-sided front", glm::dmat4(1.0), true, true},
          Row{"double-sided back", turned, true, true},
          Row{"double-sided mirrored back", mirroredAway, true, true}}) {
        Scene scene;
        Material m = unlit(glm::vec4(1));
        m.doubleSided = row.doubleSided;
        place(scene, quad(1.0f, addMaterial(scene, m)), row.worldFromModel);
        const Image image = renderer().render(request(std::move(scene), "sides")).image;
        EXPECT_EQ(centerColor(image), row.seen ? kWhite : kNothing) << row.name;
    }
}

TEST_F(Materials, BothSidesAreLitByLightsOnTheirSide) {
    glm::dmat4 turned(1.0);
    turned[0][0] = turned[2][2] = -1.0;
    glm::dmat4 mirrored(1.0);
    mirrored[0][0] = -1.0;
    for (const glm::dmat4& worldFromModel :
         {glm::dmat4(1.0), turned, mirrored, turned * mirrored}) {
        Scene scene;
        Material m;
        m.metallic = m.specular = 0.0f;
        m.doubleSided = true;
        place(scene, quad(2.0f, addMaterial(scene, m)), worldFromModel);
        addLight(scene, {.intensity = glm::vec3(3.14159265f)}, moved(0, 0, 1));
        FrameRequest r = request(std::move(scene), "both sides");
        r.width = r.height = 65;
        EXPECT_NEAR(centerColor(renderer().render(r).image).x, 1.0f, 1e-3f);
    }
}

TEST_F(Materials, WrapModesApplyPerTexture) {
    // Three texture widths over 48 pixels of the picture; nearest texel. Across the first row.
    const auto row = [](Wrap wrap) {
        Scene scene;
        Material m = unlit(glm::vec4(1));
        m.baseColorTexture.texture = addTexture2x2(scene, kFourColors, wrap);
        place(scene, repeated(1.5f, addMaterial(scene, m), 3.0f));
        const Image image = renderer().render(request(std::move(scene), "wrap")).image;
        std::vector<glm::vec3> colors;
        for (std::uint32_t i = 0; i < 6; ++i) colors.push_back(color(image, 8 + 4 + 8 * i, 12));
        return colors;
    };
    using Row = std::vector<glm::vec3>;
    EXPECT_EQ(row(Wrap::repeat), (Row{kRed, kGreen, kRed, kGreen, kRed, kGreen}));
    EXPECT_EQ(row(Wrap::mirroredRepeat), (Row{kRed, kGreen, kGreen, kRed, kRed, kGreen}));
    EXPECT_EQ(row(Wrap::clampToEdge), (Row{kRed, kGreen, kGreen, kGreen, kGreen, kGreen}));
}

TEST_F(Materials, TwoTexturesOfOneMaterialKeepTheirOwnWrap) {
    Scene scene;
    Material m;
    m.baseColor = glm::vec4(0, 0, 0, 1);
    m.metallic = m.specular = 0.0f;
    m.emissive = glm::vec3(1.0f);
    m.emissiveTexture.texture = addTexture2x2(scene, kFourColors, Wrap::clampToEdge);
    m.alphaMode = AlphaMode::mask;
    // A hole in the right half of every repeat.
    m.baseColorTexture.texture = addTexture2x2(
        scene, {glm::u8vec4(255), {255, 255, 255, 0}, glm::u8vec4(255), {255, 255, 255, 0}},
        Wrap::repeat);
    place(scene, repeated(1.5f, addMaterial(scene, m), 3.0f));
    const Image image = renderer().render(request(std::move(scene), "two wraps")).image;
    EXPECT_EQ(color(image, 12, 12), kRed);      // first texel
    EXPECT_EQ(color(image, 20, 12), kNothing);  // hole
    EXPECT_EQ(color(image, 28, 12), kGreen);    // the emissive texture is clamped by now
    EXPECT_EQ(color(image, 36, 12), kNothing);  // the hole repeats
}

TEST_F(Materials, TextureTransformsScaleRotateAndTranslate) {
    const auto corner = [](const TextureSlot& transform) {
        Scene scene;
        Material m = unlit(glm::vec4(1));
        m.baseColorTexture = transform;
        m.baseColorTexture.texture = addTexture2x2(scene, kFourColors, Wrap::repeat);
        place(scene, quad(1.0f, addMaterial(scene, m)));
        const Image image = renderer().render(request(std::move(scene), "transform")).image;
        return color(image, 20, 20);  // uv (1/8, 1/8)
    };
    EXPECT_EQ(corner({}), kRed);
    EXPECT_EQ(corner({.offset = {0.5f, 0.0f}}), kGreen);
    EXPECT_EQ(corner({.offset = {0.0f, 0.5f}}), kBlue);
    EXPECT_EQ(corner({.scale = {6.0f, 1.0f}}), kGreen);  // 6/8
    // A quarter turn: (u, v) reads (v, -u); with an offset of one half down, (1/8, 3/8): red.
    EXPECT_EQ(corner({.rotation = 1.57079633f}), kBlue);
    EXPECT_EQ(corner({.offset = {0.0f, 0.5f}, .rotation = 1.57079633f}), kRed);
}

TEST_F(Materials, TexturesUseTheirOwnCoordinateSet) {
    Scene scene;
    Material m = unlit(glm::vec4(1));
    m.baseColorTexture.texture = addTexture2x2(scene, kFourColors, Wrap::clampToEdge);
    m.baseColorTexture.texCoord = 1;
    MeshDraft draft = quad(1.0f, addMaterial(scene, m));
    for (Vertex& v : draft.vertices) v.texCoord1 = glm::vec2(0.75f, 0.25f);
    place(scene, std::move(draft));
    EXPECT_EQ(centerColor(renderer().render(request(std::move(scene), "second set")).image),
              kGreen);
}

TEST_F(Materials, VertexColoursMultiplyTheBaseColour) {
    Scene scene;
    MeshDraft draft = quad(1.0f, addMaterial(scene, unlit({1, 0.5f, 1, 1})));
    for (Vertex& v : draft.vertices) v.color = {0.25f, 0.5f, 1, 1};
    place(scene, std::move(draft));
    EXPECT_EQ(centerColor(renderer().render(request(std::move(scene), "vertex colours")).image),
              glm::vec3(0.25f, 0.25f, 1));
}

TEST_F(Materials, AFlatNormalMapChangesNothing) {
    const auto seen = [](bool mapped) {
        Scene scene;
        Material m{.baseColor = {0.5f, 0.5f, 0.5f, 1}, .metallic = 0.5f, .roughness = 0.5f};
        if (mapped) {
            // 127.5 would be flat; scaled by almost nothing, 128 is.
            m.normalScale = 1e-6f;
            m.normalTexture.texture = addTexture2x2(scene,
                                                    {glm::u8vec4(128, 128, 255, 255),
                                                     {128, 128, 255, 255},
                                                     {128, 128, 255, 255},
                                                     {128, 128, 255, 255}},
                                                    Wrap::repeat);
        }
        place(scene, quad(1.0f, addMaterial(scene, m)));
        FrameRequest r = request(std::move(scene), "flat");
        r.environment.map = "sky";
        return centerColor(renderer().render(r).image);
    };
    const glm::vec3 without = seen(false), with = seen(true);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(with[c], without[c], 1e-4f * without[c]);
}

TEST_F(Materials, PackedNormalMapsLookTheSame) {
    const auto seen = [](bool joined) {
        Scene scene;
        Material m{.baseColor = {0.8f, 0.6f, 0.5f, 1}};
        m.normalTexture.texture = addTexture2x2(scene,
                                                {glm::u8vec4(38, 128, 218, 255),
                                                 {128, 200, 230, 255},
                                                 {60, 110, 210, 255},
                                                 {128, 128, 255, 255}},
                                                Wrap::repeat, Filter::nearest);
        m.metallicRoughnessTexture.texture = addTexture2x2(scene,
                                                           {glm::u8vec4(255, 90, 255, 255),
                                                            {255, 140, 0, 255},
                                                            {255, 200, 128, 255},
                                                            {255, 250, 30, 255}},
                                                           Wrap::repeat, Filter::nearest);
        MeshDraft draft = repeated(2.0f, addMaterial(scene, m), 1.0f);
        draft.hasTangents = true;
        for (Vertex& v : draft.vertices) v.tangent = {1, 0, 0, 1};
        place(scene, std::move(draft));
        if (joined) packNormals(scene);
        EXPECT_EQ(scene.images.size(), joined ? 1u : 2u);
        FrameRequest r = request(std::move(scene), joined ? "joined" : "apart");
        r.environment.map = "sky";
        return renderer().render(r).image;
    };
    const Image apart = seen(false), joined = seen(true);
    double difference = 0.0, sum = 0.0, range = 0.0;
    for (std::uint32_t y = 0; y < apart.height; ++y) {
        for (std::uint32_t x = 0; x < apart.width; ++x) {
            const glm::dvec3 expected = color(apart, x, y);
            difference += glm::length(glm::dvec3(color(joined, x, y)) - expected);
            range += glm::length(expected - glm::dvec3(color(apart, 0, 0)));
            sum += glm::length(expected);
        }
    }
    EXPECT_GT(range, 0.1 * sum) << "the bumps show";
    EXPECT_LT(difference, 0.01 * sum);  // x and y are rounded again
}

TEST_F(Materials, NormalMapsPerturbTheNormal) {
    // Tangent +X, bitangent +Y (glTF: green up). A normal of (s, 0, s) faces a light at 45 degrees.
    const auto seen = [](const glm::u8vec4& texel, const glm::dvec3& light, const glm::dmat4& m) {
        Scene scene;
        Material material;
        material.metallic = material.specular = 0.0f;
        material.doubleSided = true;
        material.normalTexture.texture =
            addTexture2x2(scene, {texel, texel, texel, texel}, Wrap::repeat);
        MeshDraft draft = quad(2.0f, addMaterial(scene, material));
        draft.hasTangents = true;
        for (Vertex& v : draft.vertices) v.tangent = {1, 0, 0, 1};
        place(scene, std::move(draft), m);
        addLight(scene, {.intensity = glm::vec3(3.14159265f)}, moved(light.x, light.y, light.z));
        FrameRequest r = request(std::move(scene), "tilted");
        r.width = r.height = 65;
        return centerColor(renderer().render(r).image).x;
    };
    const glm::u8vec4 right(218, 128, 218, 255), up(128, 218, 218, 255);
    const double s = std::sqrt(0.5);
    const glm::dmat4 upright(1.0);
    EXPECT_NEAR(seen(right, {s, 0, s}, upright), 1.0f, 0.01f);
    EXPECT_NEAR(seen(right, {-s, 0, s}, upright), 0.0f, 0.01f);
    EXPECT_NEAR(seen(up, {0, s, s}, upright), 1.0f, 0.01f);
    EXPECT_NEAR(seen(up, {0, -s, s}, upright), 0.0f, 0.01f);
    // Mirrored along X, the picture's right is the world's left; up stays up.
    glm::dmat4 mirrored(1.0);
    mirrored[0][0] = -1.0;
    EXPECT_NEAR(seen(right, {-s, 0, s}, mirrored), 1.0f, 0.01f);
    EXPECT_NEAR(seen(up, {0, s, s}, mirrored), 1.0f, 0.01f);
}
