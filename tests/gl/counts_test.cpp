// Counts OpenGL calls of frames: they match the plan, and nothing invisible or unrequested is
// drawn.
#include "support.h"

#include <algorithm>
#include <set>

namespace clerestory::test {
namespace {

class Counts : public GlTest {};

struct Counted {
    Frame frame;
    std::uint64_t draws = 0, triangles = 0;
};
Counted counted(const FrameRequest& r) {
    const RendererCounters before = renderer().counters();
    Counted result{.frame = renderer().render(r)};
    const RendererCounters after = renderer().counters();
    result.draws = after.drawCalls - before.drawCalls;
    result.triangles = after.triangles - before.triangles;
    return result;
}

// A software driver that can read vertices and indices where they lie makes no copy of them.
TEST_F(Counts, GeometryIsStoredOnce) {
    Scene scene;
    place(scene, sphere(0.5f, 16, addMaterial(scene, glowing({1, 2, 3}))));
    const std::uint64_t bytes =
        scene.vertices.size() * sizeof(Vertex) + scene.indices.size() * sizeof(std::uint32_t);
    const std::uint64_t before = renderer().counters().bytesShared;
    request(std::move(scene), "held once");
    EXPECT_EQ(renderer().counters().bytesShared - before,
              renderer().identity().readsClientMemory ? bytes : 0);
}

// The scene's memory is the driver's: it must stay where it is while other scenes come and go.
TEST_F(Counts, ClientMemoryScenesAreNotModified) {
    Scene scene;
    place(scene, sphere(0.5f, 16, addMaterial(scene, glowing({1, 2, 3}))));
    const FrameRequest r = request(std::move(scene), "stays");
    const Image first = renderer().render(r).image;
    for (int i = 0; i < 3; ++i) {
        Scene other;
        place(other, sphere(0.1f + 0.1f * static_cast<float>(i), 16,
                            addMaterial(other, glowing({3, 2, 1}))));
        renderer().render(request(std::move(other), "comes and goes"));
    }
    EXPECT_EQ(renderer().render(r).image.data, first.data);
}

// One body for each feature that RendererOptions::fewPrograms shares, under a light and a sky.
Scene bodiesOfAllTextures() {
    Scene scene;
    scene.environment = "sky";
    const Index colors = addTexture2x2(
        scene, {{{255, 40, 90, 255}, {20, 200, 10, 255}, {7, 70, 250, 255}, {99, 9, 180, 255}}},
        Wrap::repeat);
    const Index numbers = addTexture2x2(
        scene,
        {{{255, 90, 0, 255}, {255, 130, 255, 255}, {255, 220, 30, 255}, {255, 60, 200, 255}}},
        Wrap::repeat);
    Material plain{.name = "plain",
                   .baseColor = {0.7f, 0.31f, 0.53f, 1.0f},
                   .metallic = 0.3f,
                   .roughness = 0.61f,
                   .emissive = {0.01f, 0.02f, 0.03f}};
    std::vector<Material> materials(6, plain);
    materials[1].baseColorTexture.texture = colors;
    materials[2].baseColorTexture = {.texture = colors, .scale = {3.0f, 2.0f}};
    materials[3].emissiveTexture = {.texture = colors, .texCoord = 1};
    materials[4].metallicRoughnessTexture.texture = numbers;
    materials[5].metallic = 0.0f;
    materials[5].roughness = 0.95f;
    for (std::size_t i = 0; i < materials.size(); ++i) {
        for (const bool colored : {false, true}) {
            MeshDraft body = sphere(0.22f, 12, addMaterial(scene, materials[i]));
            for (Vertex& v : body.vertices) {
                if (colored) v.color = glm::vec4(0.5f * v.normal + 0.5f, 1.0f);
            }
            place(scene, std::move(body),
                  moved(0.5 * static_cast<double>(i) - 1.25, colored ? 0.4 : -0.4, -0.3));
        }
    }
    addLight(scene, {.kind = LightKind::point, .intensity = glm::vec3(30.0f)},
             moved(0.4, 0.5, 2.5));
    return scene;
}

// Materials share programs without other bytes, to the last digit of linear colour. Software
// drivers only: a graphics card would compute what a program does not need.
TEST_F(Counts, FewProgramsDrawTheSameBytes) {
    FrameRequest r = request(bodiesOfAllTextures(), "textures");
    r.width = r.height = 200;
    std::vector<Image> images;
    std::vector<std::uint64_t> programs;
    for (const bool few : {false, true}) {
        Renderer own({.debugOutput = true, .fewPrograms = few});
        Scene scene = bodiesOfAllTextures();
        updateContentHash(scene);
        scene.id = "textures";
        own.addScene(std::move(scene));
        images.push_back(own.render(r).image);
        programs.push_back(own.counters().programsMade);
        EXPECT_EQ(own.driverMessages(), std::vector<std::string>{});
    }
    EXPECT_EQ(differing(images[0], images[1]), 0u);
    EXPECT_LE(programs[1] + (renderer().identity().software ? 5 : 0), programs[0]);
}

// Every kind of pass, in one frame and in the next: what the plan counts is what was drawn.
TEST_F(Counts, MatchThePlanForEveryKindOfPass) {
    Scene scene;
    Material glass{.name = "glass", .metallic = 0.0f, .roughness = 0.0f, .transmission = 1.0f};
    place(scene, quad(0.5f, addMaterial(scene, glass)), moved(-0.5, 0, 0.5));
    glass.thickness = 0.5f;
    place(scene, sphere(0.3f, 16, addMaterial(scene, glass)), moved(0.6, 0.3, 0.3));
    place(scene, quad(1.5f, addMaterial(scene, mirrorMetal(0.9f, 0.2f))));
    place(scene, sphere(0.3f, 16, addMaterial(scene, mirrorMetal())), moved(0.3, -0.6, 0.4));
    place(scene, quad(0.2f, addMaterial(scene, glowing({1, 2, 3}))), moved(-0.2, 0.6, 0.3));
    FrameRequest r = request(std::move(scene), "all kinds");
    r.environment.map = "sky";
    r.accuracy.planar = PlanarMethod::mirror;
    r.accuracy.curved = CurvedMethod::probe;
    r.accuracy.glass = GlassMethod::backdrop;
    r.accuracy.backFaces = true;
    r.accuracy.probeSize = 32;
    std::set<std::string_view> kinds;
    for (int frame = 0; frame < 2; ++frame) {
        const Counted drawn = counted(r);
        const PlanTotals planned = totals(drawn.frame.plan);
        EXPECT_EQ(drawn.draws, planned.draws);
        EXPECT_EQ(drawn.triangles, planned.triangles);
        EXPECT_EQ(drawn.frame.passTimes.size(), planned.passes);
        EXPECT_EQ(drawn.frame.plan.passes.size(), planned.passes);
        for (const Pass& pass : drawn.frame.plan.passes) {
            if (frame == 0) kinds.insert(pass.kind());
            if (frame == 1) {
                EXPECT_NE(pass.kind(), "capture") << pass.name;
                EXPECT_NE(pass.kind(), "prefilter") << pass.name;
            }
        }
    }
    for (const std::string_view kind : {"surface", "mirror", "capture", "prefilter", "levels",
                                        "backdrop", "glass", "backFaces"}) {
        EXPECT_TRUE(kinds.contains(kind)) << kind;
    }
}

// A mirror, a mirror ball and a piece of glass that the camera does not see: OpenGL draws what it
// draws of the scene without them.
TEST_F(Counts, InvisibleObjectsAreDrawnInNoView) {
    const auto scene = [](bool with) {
        Scene s;
        place(s, quad(0.5f, addMaterial(s, glowing({1, 0.5f, 0.2f}))));
        if (!with) return s;
        const Index metal = addMaterial(s, mirrorMetal());
        Material glass{.name = "glass", .metallic = 0.0f, .roughness = 0.0f, .transmission = 1.0f};
        place(s, quad(0.5f, metal), moved(0, 0, 4));  // behind the eye
        place(s, sphere(0.4f, 16, metal), moved(1, 0, 5));
        place(s, quad(0.5f, addMaterial(s, glass)), moved(-1, 0, 5));
        return s;
    };
    const auto drawn = [&](bool with) {
        FrameRequest r = request(scene(with), with ? "with" : "without");
        r.accuracy.planar = PlanarMethod::mirror;
        r.accuracy.curved = CurvedMethod::probe;
        return counted(r);
    };
    const Counted without = drawn(false), with = drawn(true);
    EXPECT_EQ(with.draws, without.draws);
    EXPECT_EQ(with.triangles, without.triangles);
    EXPECT_EQ(with.frame.image.data, without.frame.image.data);
    EXPECT_EQ(with.frame.plan.targets.size(), without.frame.plan.targets.size());
}

TEST_F(Counts, EmissionOffEqualsASceneWithoutEmission) {
    const auto scene = [](float strength) {
        Scene s;
        Material lamp{.baseColor = {0.6f, 0.5f, 0.4f, 1}, .metallic = 0.0f};
        lamp.emissive = {1, 0.5f, 0.25f};
        lamp.emissiveStrength = strength;
        place(s, sphere(0.6f, 24, addMaterial(s, lamp)), moved(-0.5, 0, 0));
        place(s, quad(0.8f, addMaterial(s, mirrorMetal(0.9f))), moved(0.7, 0, -0.5));
        return s;
    };
    const auto picture = [&](float strength, bool emission) {
        FrameRequest r = request(scene(strength), "glow");
        r.environment.map = "sky";
        r.accuracy.planar = PlanarMethod::mirror;
        r.effects.emission = emission;
        return renderer().render(r).image.data;
    };
    const auto off = picture(3.0f, false);
    EXPECT_EQ(off, picture(0.0f, true));
    EXPECT_NE(off, picture(3.0f, true));
}

// Maps stay resident within the memory budget: the least recently used one is evicted, and redrawn
// with the same bytes at its next request.
TEST_F(Counts, MapsBeyondTheMemoryBudgetAreReleased) {
    Scene scene;
    place(scene, quad(2.0f, addMaterial(scene, glowing({1, 2, 3}))), moved(0, 0, -2));
    place(scene, sphere(0.5f, 12, addMaterial(scene, mirrorMetal())));
    FrameRequest r = request(std::move(scene), "budget");
    r.accuracy.curved = CurvedMethod::probe;
    r.accuracy.generations = 1;
    r.accuracy.probeSize = 512;  // 16.8 MB with its levels, of 128 MB
    const auto facesDrawn = [&](std::uint32_t samples, Image* image = nullptr) {
        r.accuracy.probeSamples = samples;
        const Frame frame = renderer().render(r);
        if (image) *image = frame.image;
        return std::count_if(frame.plan.passes.begin(), frame.plan.passes.end(),
                             [](const Pass& pass) { return pass.kind() == "capture"; });
    };
    Image first, again;
    EXPECT_EQ(facesDrawn(1, &first), 6);
    EXPECT_EQ(facesDrawn(2), 6);
    EXPECT_EQ(facesDrawn(1), 0) << "two have room";
    for (std::uint32_t samples = 2; samples <= 9; ++samples) facesDrawn(samples);
    EXPECT_EQ(facesDrawn(9), 0) << "the last is there";
    EXPECT_EQ(facesDrawn(1, &again), 6) << "the first was evicted";
    EXPECT_EQ(again.data, first.data);
}

}  // namespace
}  // namespace clerestory::test
