// Light between surfaces of scenes that are hard to compute: extreme radiance, broken and
// overlapping geometry, very many triangles. Frames stay finite and the work stays bounded.
#include "support.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <future>
#include <thread>
#include <utility>

using namespace clerestory;
using namespace clerestory::test;

namespace {

class LightLimits : public GlTest {};

Material matteBothSides(float albedo, float emitted = 0.0f) {
    Material m;
    m.baseColor = glm::vec4(glm::vec3(albedo), 1.0f);
    m.metallic = 0.0f;
    m.emissive = glm::vec3(emitted);
    m.doubleSided = true;
    return m;
}

// The frame with complete light. Its texels are finite and not negative.
Image litFrame(FrameRequest r) {
    r.effects.indirectLight = r.effects.shadows = true;
    const LightState light = renderer().completeLight(r);
    EXPECT_TRUE(light.complete) << light.failure;
    Frame frame = renderer().render(r, Readback::health);
    for (const TargetHealth& target : frame.health) {
        EXPECT_EQ(target.nonFinite, 0u) << target.target;
        EXPECT_EQ(target.negative, 0u) << target.target;
    }
    return std::move(frame.image);
}

FrameRequest lookingDown(Scene scene, const char* id) {
    FrameRequest r = request(std::move(scene), id, {0.0, 0.0, 2.0});
    r.environment.map = "white";
    return r;
}

}  // namespace

TEST_F(LightLimits, ExtremeRadianceStaysFinite) {
    for (const float emitted : {1e-30f, 1e4f, 6e4f}) {
        Scene scene;
        place(scene, quad(2.0f, addMaterial(scene, matteBothSides(1.0f))));
        place(scene, quad(0.5f, addMaterial(scene, matteBothSides(1.0f, emitted))),
              moved(0.0, 0.0, 0.5));
        addLight(scene, {.intensity = glm::vec3(6e4f)}, moved(1.0, 0.0, 0.5));
        const glm::vec3 onFloor = color(litFrame(lookingDown(std::move(scene), "extreme")), 8, 32);
        EXPECT_TRUE(std::isfinite(onFloor.x));
        EXPECT_GT(onFloor.x, 0.0f);
    }
}

// Triangles without area, twice the same surface, and surfaces that pass through each other change
// what an undisturbed floor shows by no more than its noise.
TEST_F(LightLimits, BrokenGeometryDoesNotDisturbItsNeighbours) {
    Scene scene;
    const Index grey = addMaterial(scene, matteBothSides(0.5f));
    place(scene, quad(2.0f, grey));
    place(scene, quad(2.0f, grey));  // again
    MeshDraft broken = quad(1.0f, grey);
    const Vertex corner = broken.vertices[0];
    const auto first = static_cast<std::uint32_t>(broken.vertices.size());
    for (int i = 0; i < 3; ++i) broken.vertices.push_back(corner);
    for (const std::uint32_t i : {0u, 1u, 2u}) broken.indices.push_back(first + i);  // a point
    for (const std::uint32_t i : {0u, 1u, 0u}) broken.indices.push_back(i);          // a line
    place(scene, std::move(broken), moved(0.0, 0.0, -0.5));
    const glm::dmat4 upright =
        glm::rotate(glm::dmat4(1.0), 1.5707963267948966, glm::dvec3(0.0, 1.0, 0.0));
    place(scene, quad(0.1f, grey), glm::translate(glm::dmat4(1.0), {1.8, 1.8, 0.0}) * upright);
    const Image image = litFrame(lookingDown(std::move(scene), "broken"));
    // An open floor of albedo 0.5 under a white sky.
    EXPECT_NEAR(centerColor(image).x, 0.5f, 0.03f);
}

// A floor of a million triangles. The time is printed; the number of places where light is gathered
// has a limit, so that it does not grow with the triangles.
// Rays end in a stack of more sheets than a ray passes, and nothing is known of the surface behind
// them. The vertices of the first instance are not the first ones of the scene.
TEST_F(LightLimits, RaysEndInAStackOfManySheets) {
    Scene scene;
    Material sheet = matteBothSides(1.0f);
    sheet.alphaMode = AlphaMode::blend;
    sheet.baseColor.a = 0.01f;
    sheet.unlit = true;  // no light is computed for it
    addMesh(scene, sphere(1.0f, 32, addMaterial(scene, sheet)));
    const Index square = addMesh(scene, quad(0.2f, addMaterial(scene, sheet)));
    const Index floor = addMesh(scene, quad(2.0f, addMaterial(scene, matteBothSides(0.5f))));
    addInstance(scene, addNode(scene, "floor"), floor);
    for (int i = 1; i <= 30; ++i) {
        addInstance(scene, addNode(scene, "sheet", moved(0.0, 0.0, 0.01 * i)), square);
    }
    FrameRequest r = lookingDown(std::move(scene), "sheets");
    r.effects.indirectLight = true;
    EXPECT_TRUE(renderer().completeLight(r).complete);
}

TEST_F(LightLimits, AMillionTrianglesAreComputedCoarsely) {
    constexpr std::uint32_t kEdge = 708;
    Scene scene;
    MeshDraft grid;
    grid.name = "grid";
    grid.material = addMaterial(scene, matteBothSides(0.5f));
    grid.hasNormals = grid.hasTexCoords = true;
    for (std::uint32_t y = 0; y <= kEdge; ++y) {
        for (std::uint32_t x = 0; x <= kEdge; ++x) {
            Vertex v;
            v.position = {4.0f * float(x) / kEdge - 2.0f, 4.0f * float(y) / kEdge - 2.0f, 0.0f};
            grid.vertices.push_back(v);
            if (x == kEdge || y == kEdge) continue;
            const std::uint32_t a = y * (kEdge + 1) + x, b = a + kEdge + 1;
            grid.indices.insert(grid.indices.end(), {a, a + 1, b + 1, a, b + 1, b});
        }
    }
    place(scene, std::move(grid));
    // Hides the sky from what is right below it.
    place(scene, quad(0.5f, addMaterial(scene, matteBothSides(0.0f))), moved(0.0, 0.0, 0.1));
    FrameRequest r = lookingDown(std::move(scene), "million");
    const auto began = std::chrono::steady_clock::now();
    const Image image = litFrame(r);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - began;
    std::printf("light of a million triangles: %.1f s\n", seconds.count());
    EXPECT_NEAR(color(image, 4, 4).x, 0.5f, 0.03f);
}

// A thread that waits takes part in the computation, which rests while a frame is drawn. Its wait
// can be abandoned all the same.
TEST_F(LightLimits, AWaitEndsWhileAFrameIsDrawn) {
    Scene scene;
    for (int i = 0; i < 6; ++i) {
        place(scene, sphere(0.3f, 64, addMaterial(scene, matteBothSides(0.5f))),
              moved(0.5 * i - 1.25, 0.0, 0.0));
    }
    FrameRequest lit = lookingDown(std::move(scene), "abandoned wait");
    lit.effects.indirectLight = true;
    LightState light = renderer().light(lit);
    while (light.revision == 0) light = renderer().light(lit);  // the next round begins
    ASSERT_FALSE(light.complete);
    Scene other;
    place(other, quad(0.5f, addMaterial(other, matteBothSides(0.5f))));
    const FrameRequest frame = lookingDown(std::move(other), "frame meanwhile");
    std::future<void> waiting;
    renderer().render(frame, Readback::picture, [&] {
        if (waiting.valid()) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        waiting = std::async(std::launch::async, [&] {
            int asked = 0;
            light.wait([&] { return ++asked > 2; });
        });
        EXPECT_EQ(waiting.wait_for(std::chrono::seconds(60)), std::future_status::ready);
        return false;
    });
    waiting.get();
    EXPECT_TRUE(renderer().completeLight(lit).complete);
}
