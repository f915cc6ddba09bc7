// Ray hits are shaded like pixels: equal in a drawn and a traced mirror, and equal directly and
// through traced glass of index 1.
#include "../support/compare_images.h"
#include "support.h"
#include "trace_support.h"

#include <algorithm>
#include <functional>

using namespace clerestory;
using namespace clerestory::test;

namespace {

struct HitCase {
    std::string name;
    std::function<Material(Scene&)> material;
    LightKind light = LightKind::point;
    std::string environment = "sky";
    bool colored = false;  // vertex colours
    bool square = true;    // next to the ball
};
void PrintTo(const HitCase& c, std::ostream* out) {
    *out << c.name;
}

Material matt(const glm::vec4& color, float roughness = 0.6f) {
    return {.baseColor = color,
            .metallic = 0.0f,
            .roughness = roughness,
            .reflection = Reflection::none};
}

TextureSlot textured(Scene& scene, const std::array<glm::u8vec4, 4>& texels,
                     ColorSpace space = ColorSpace::srgb, Filter filter = Filter::linear) {
    const Index texture = addTexture2x2(scene, texels, Wrap::repeat, filter);
    scene.images.back().colorSpace = space;
    return {.texture = texture};
}

const std::array<glm::u8vec4, 4> kColors = {
    glm::u8vec4(230, 40, 20, 255), {30, 200, 60, 255}, {20, 40, 220, 255}, {240, 240, 200, 255}};

std::vector<HitCase> hitCases() {
    const auto plain = [](Scene&) { return matt({0.7f, 0.4f, 0.2f, 1.0f}); };
    const auto metal = [](float roughness) {
        return [roughness](Scene&) {
            Material m = matt({1.0f, 0.8f, 0.4f, 1.0f}, roughness);
            m.metallic = 1.0f;
            return m;
        };
    };
    return {
        {"pointLamp", plain, LightKind::point},
        {"spot", plain, LightKind::spot},
        {"directional", plain, LightKind::directional},
        {"gloss",
         [](Scene&) {
             return matt({0.2f, 0.2f, 0.2f, 1.0f}, 0.15f);
         }},
        {"specularZero",
         [](Scene&) {
             Material m = matt({0.2f, 0.4f, 0.2f, 1.0f}, 0.1f);
             m.specular = 0.0f;
             return m;
         }},
        {"roughMetal", metal(0.5f)},
        {"smoothMetal", metal(0.15f)},
        {.name = "turningMetal",
         .material =
             [](Scene&) {
                 Material m = matt({1.0f, 0.8f, 0.4f, 1.0f}, 0.2f);
                 m.metallic = 1.0f;
                 m.reflection = Reflection::automatic;
                 return m;
             },
         .light = LightKind::spot,  // away from the mirror, where rays that turn would see it
         .environment = "black",
         .square = false},
        {"textured",
         [](Scene& scene) {
             Material m = matt(glm::vec4(1.0f));
             m.baseColorTexture = textured(scene, kColors);
             m.baseColorTexture.scale = {2.0f, 1.5f};
             m.baseColorTexture.rotation = 0.4f;
             return m;
         }},
        {"metallicRoughnessTextured",
         [](Scene& scene) {
             Material m = matt({0.9f, 0.7f, 0.5f, 1.0f}, 1.0f);
             m.metallic = 1.0f;
             m.metallicRoughnessTexture = textured(scene,
                                                   {glm::u8vec4(0, 90, 255, 255),
                                                    {0, 140, 0, 255},
                                                    {0, 200, 128, 255},
                                                    {0, 250, 30, 255}},
                                                   ColorSpace::linear);
             return m;
         }},
        {"normalMapped",
         [](Scene& scene) {
             Material m = matt({0.6f, 0.6f, 0.6f, 1.0f}, 0.4f);
             m.normalTexture = textured(scene,
                                        {glm::u8vec4(160, 128, 240, 255),
                                         {128, 90, 240, 255},
                                         {100, 140, 240, 255},
                                         {128, 128, 255, 255}},
                                        ColorSpace::linear);
             return m;
         }},
        {"packedNormal",
         [](Scene& scene) {
             Material m = matt({0.8f, 0.6f, 0.6f, 1.0f}, 1.0f);
             m.metallic = 1.0f;
             m.normalTexture = textured(scene,
                                        {glm::u8vec4(160, 0, 90, 160),
                                         {128, 160, 0, 90},
                                         {100, 200, 255, 140},
                                         {128, 240, 128, 128}},
                                        ColorSpace::linear);
             m.metallicRoughnessTexture = m.normalTexture;
             scene.images.back().packedNormal = true;
             return m;
         }},
        {"emissive",
         [](Scene& scene) {
             Material m = matt({0.1f, 0.1f, 0.1f, 1.0f});
             m.emissive = {0.4f, 0.6f, 0.2f};
             m.emissiveTexture = textured(scene, kColors);
             return m;
         }},
        {"masked",
         [](Scene& scene) {
             Material m = matt(glm::vec4(1.0f));
             m.alphaMode = AlphaMode::mask;
             m.doubleSided = true;
             m.baseColorTexture = textured(scene,
                                           {glm::u8vec4(200, 40, 20, 0),
                                            {30, 200, 60, 255},
                                            {20, 40, 220, 255},
                                            {240, 240, 200, 0}},
                                           ColorSpace::srgb, Filter::nearest);
             return m;
         }},
        {"blended",
         [](Scene&) {
             Material m = matt({0.9f, 0.3f, 0.2f, 0.4f});
             m.alphaMode = AlphaMode::blend;
             return m;
         }},
        {"clearcoat",
         [](Scene& scene) {
             Material m = matt({0.5f, 0.1f, 0.1f, 1.0f});
             m.clearcoat = 1.0f;
             m.clearcoatTexture = textured(scene, kColors, ColorSpace::linear);
             m.clearcoatRoughness = 0.3f;
             m.clearcoatNormalTexture = textured(scene,
                                                 {glm::u8vec4(150, 128, 240, 255),
                                                  {128, 110, 240, 255},
                                                  {110, 134, 240, 255},
                                                  {128, 128, 255, 255}},
                                                 ColorSpace::linear);
             return m;
         }},
        {"sheen",
         [](Scene& scene) {
             Material m = matt({0.1f, 0.1f, 0.1f, 1.0f});
             m.sheenColor = {0.9f, 0.8f, 0.7f};
             m.sheenColorTexture = textured(scene, kColors);
             m.sheenRoughness = 0.5f;
             return m;
         }},
        {"iridescence",
         [](Scene& scene) {
             Material m = matt({0.1f, 0.1f, 0.1f, 1.0f}, 0.5f);
             m.iridescence = 1.0f;
             m.iridescenceThicknessTexture = textured(scene, kColors, ColorSpace::linear);
             return m;
         }},
        {"diffuseTransmission",
         [](Scene&) {
             Material m = matt({0.5f, 0.5f, 0.1f, 1.0f});
             m.diffuseTransmission = 0.7f;
             m.diffuseTransmissionColor = {0.2f, 0.9f, 0.3f};
             m.doubleSided = true;
             return m;
         }},
        {"specularTextured",
         [](Scene& scene) {
             Material m = matt({0.1f, 0.1f, 0.1f, 1.0f}, 0.4f);
             m.specularColor = {4.0f, 3.0f, 2.0f};
             m.specularColorTexture = textured(scene, kColors);
             return m;
         }},
        {"unlit",
         [](Scene& scene) {
             Material m = matt(glm::vec4(1.0f));
             m.unlit = true;
             m.baseColorTexture = textured(scene, kColors);
             return m;
         }},
        {.name = "vertexColors", .material = plain, .colored = true},
        {"transmissionTextured",
         [](Scene& scene) {
             Material m = matt({0.9f, 0.7f, 0.5f, 1.0f}, 0.0f);
             m.specular = 0.0f;  // at the eye what it mirrors is followed, too
             m.transmission = 1.0f;
             m.transmissionTexture = textured(
                 scene,
                 {glm::u8vec4(0, 0, 0, 255), {80, 0, 0, 255}, {160, 0, 0, 255}, {255, 0, 0, 255}},
                 ColorSpace::linear);
             return m;
         }},
    };
}

// A ball and a square before a matt wall; `place` puts them into the world.
Scene things(const HitCase& c, const glm::dmat4& world) {
    Scene scene;
    scene.environment = c.environment;
    const Index wall = addMaterial(scene, matt({0.3f, 0.4f, 0.6f, 1.0f}));
    const Index material = addMaterial(scene, c.material(scene));
    MeshDraft square = quad(0.6f, material), ball = sphere(0.5f, 40, material);
    for (MeshDraft* draft : {&square, &ball}) {
        for (Vertex& v : draft->vertices) {
            if (!c.colored) break;
            v.color = glm::vec4(0.5f + 0.5f * glm::normalize(v.position + glm::vec3(0.1f)), 1.0f);
        }
    }
    if (c.square) place(scene, square, world * moved(-0.65, 0, 0));
    place(scene, ball, world * moved(c.square ? 0.6 : 0.0, 0, 0));
    if (c.square) place(scene, quad(3.0f, wall), world * moved(0, 0, -1));
    Light lamp{.kind = c.light, .intensity = glm::vec3(4.0f, 3.5f, 3.0f), .outerConeAngle = 0.6f};
    if (c.light == LightKind::directional) lamp.intensity *= 0.3f;
    glm::dmat4 stand = moved(0.4, 0.9, 1.6);
    // Its -Z axis points to the centre.
    const glm::dvec3 from(stand[3]), back = glm::normalize(from);
    const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), back));
    stand[0] = glm::dvec4(right, 0.0);
    stand[1] = glm::dvec4(glm::cross(back, right), 0.0);
    stand[2] = glm::dvec4(back, 0.0);
    addLight(scene, lamp, world * stand);
    return scene;
}

FrameRequest mirrorShot(const glm::dvec3& eye, const glm::dvec3& target) {
    FrameRequest r;
    r.effects.shadows = r.effects.indirectLight = false;
    r.width = r.height = 160;
    r.camera.position = eye;
    r.camera.target = target;
    r.camera.yfov = 0.9;
    r.output.format = OutputFormat::png;
    r.accuracy.edgeFilter = false;
    r.accuracy.samples = 1;
    r.accuracy.curved = CurvedMethod::environment;
    r.accuracy.glass = GlassMethod::backdrop;
    r.accuracy.generations = 1;
    r.accuracy.bounces = 4;
    return r;
}

void expectTheSameInDrawnAndTracedMirrors(const HitCase& c) {
    // Behind the eye, turned towards the mirror before it.
    Scene scene = things(c, glm::dmat4(1.0));
    glm::dmat4 turned = moved(0.2, 0.1, 3.2);
    turned[0][0] = turned[2][2] = -1.0;
    Material perfect{.metallic = 1.0f, .roughness = 0.0f};
    place(scene, quad(0.9f, addMaterial(scene, perfect)), turned);
    PlanRunner& bench = workbench();
    bench.show(std::move(scene));
    FrameRequest r = mirrorShot({0, 0, 2}, {0.1, 0.05, 3.2});
    r.accuracy.planar = PlanarMethod::mirror;
    const FramePlan drawn = bench.plan(r);
    EXPECT_FALSE(tracesAnything(drawn)) << toText(drawn);
    r.accuracy.planar = PlanarMethod::traced;
    const FramePlan traced = bench.plan(r);
    ASSERT_TRUE(tracesAnything(traced)) << toText(traced);
    const Image expected = bench.run(drawn), actual = bench.run(traced);
    EXPECT_TRUE(imagesMatch(actual, expected, kEdges)) << toText(traced);
}

class TracedHits : public ::testing::TestWithParam<HitCase> {};

}  // namespace

TEST_P(TracedHits, LookEqualInTracedAndDrawnMirrors) {
    expectTheSameInDrawnAndTracedMirrors(GetParam());
}

TEST_P(TracedHits, AreUnchangedBehindIndexOneGlass) {
    const FrameRequest r = mirrorShot({0, 0, 2.5}, {0, 0, 0});
    PlanRunner& bench = workbench();
    bench.show(things(GetParam(), glm::dmat4(1.0)));
    const Image expected = bench.run(bench.plan(r));
    Scene scene = things(GetParam(), glm::dmat4(1.0));
    Material air{.metallic = 0.0f,
                 .roughness = 0.0f,
                 .ior = 1.0f,
                 .specular = 0.0f,
                 .transmission = 1.0f,
                 .thickness = 0.2f};
    place(scene, sphere(0.2f, 16, addMaterial(scene, air)), moved(-0.1, 0.05, 1.8));
    bench.show(std::move(scene));
    FrameRequest through = r;
    through.accuracy.glass = GlassMethod::traced;
    const FramePlan traced = bench.plan(through);
    ASSERT_TRUE(tracesAnything(traced)) << toText(traced);
    EXPECT_TRUE(imagesMatch(bench.run(traced), expected, kEdges)) << toText(traced);
}

// Seen directly, rays follow what its metal mirrors.
TEST(TracedGlass, HalfMetallicGlassLooksEqualInTracedAndDrawnMirrors) {
    Material m = matt({0.9f, 0.6f, 0.3f, 1.0f}, 0.4f);
    m.metallic = 0.4f;
    m.specular = 0.0f;
    m.transmission = 0.6f;
    expectTheSameInDrawnAndTracedMirrors({"halfMetalHalfClear", [&](Scene&) { return m; }});
}

// A sheet is a pane for any thickness of its material: rays that hit it from a mirror leave it
// as they came, as the backdrop has it.
TEST(TracedGlass, ASheetWithThicknessIsAPane) {
    const auto picture = [](float thickness) {
        Scene scene;
        scene.environment = "white";
        const Index wall = addMaterial(scene, {.unlit = true});
        MeshDraft graded = quad(3.0f, wall);
        for (Vertex& v : graded.vertices) {
            v.color = glm::vec4(0.5f + v.position.x / 6.0f, 0.5f + v.position.y / 6.0f, 0, 1);
        }
        place(scene, std::move(graded), moved(0, 0, -2));
        const Index sheet = addMaterial(scene, {.metallic = 0.0f,
                                                .roughness = 0.0f,
                                                .doubleSided = true,
                                                .ior = 1.5f,
                                                .transmission = 1.0f,
                                                .thickness = thickness});
        place(scene, quad(0.9f, sheet), moved(0, 0, -0.5));
        glm::dmat4 turned = moved(0.2, 0.1, 3.2);
        turned[0][0] = turned[2][2] = -1.0;
        place(scene, quad(0.9f, addMaterial(scene, mirrorMetal())), turned);
        PlanRunner& bench = workbench();
        bench.show(std::move(scene));
        FrameRequest r = mirrorShot({0, 0, 2}, {0.1, 0.05, 3.2});
        r.accuracy.planar = PlanarMethod::traced;
        return bench.run(bench.plan(r));
    };
    EXPECT_TRUE(imagesMatch(picture(0.001f), picture(0.0f), kRounding));
}

INSTANTIATE_TEST_SUITE_P(Materials, TracedHits, ::testing::ValuesIn(hitCases()),
                         [](const auto& each) { return each.param.name; });
