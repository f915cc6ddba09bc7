// Emission is exact and affects nothing else.
#include "support.h"

using namespace clerestory;
using namespace clerestory::test;

namespace {

class Emission : public GlTest {};

// Reflects nothing.
Material emitter(const glm::vec3& emitted, float strength) {
    Material m;
    m.baseColor = glm::vec4(0, 0, 0, 1);
    m.metallic = 0.0f;
    m.specular = 0.0f;
    m.emissive = emitted;
    m.emissiveStrength = strength;
    return m;
}

void expectNear(const glm::vec3& seen, const glm::vec3& expected, float relative) {
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(seen[c], expected[c], relative * std::max(expected[c], 1e-6f))
            << "channel " << c;
    }
}

}  // namespace

TEST_F(Emission, AnEmitterInTheDarkShowsExactlyItsRadiance) {
    for (const glm::vec3& emitted :
         {glm::vec3(1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, 0, 1), glm::vec3(0.5f, 0.25f, 1)}) {
        for (const float strength : {0.001f, 1.0f, 10.0f, 5000.0f}) {
            Scene scene;
            place(scene, quad(1.0f, addMaterial(scene, emitter(emitted, strength))));
            const Frame frame = renderer().render(request(std::move(scene), "emitter"));
            expectNear(centerColor(frame.image), strength * emitted, 1e-3f);
            EXPECT_EQ(color(frame.image, 1, 1), glm::vec3(0.0f)) << "next to the emitter";
        }
    }
}

TEST_F(Emission, IsMultipliedByItsTexture) {
    Scene scene;
    Material m = emitter(glm::vec3(1.0f), 4.0f);
    m.emissiveTexture.texture = addTexture2x2(
        scene, {glm::u8vec4(255, 0, 0, 255), {0, 255, 0, 255}, {0, 0, 255, 255}, {51, 51, 51, 255}},
        Wrap::clampToEdge);
    place(scene, quad(1.0f, addMaterial(scene, m)));
    const Frame frame = renderer().render(request(std::move(scene), "emissive texture"));
    // The quad covers the middle half of the picture, its texture's first row on top.
    expectNear(color(frame.image, 24, 24), {4, 0, 0}, 1e-3f);
    expectNear(color(frame.image, 40, 24), {0, 4, 0}, 1e-3f);
    expectNear(color(frame.image, 24, 40), {0, 0, 4}, 1e-3f);
    expectNear(color(frame.image, 40, 40), glm::vec3(0.8f), 1e-3f);
}

TEST_F(Emission, IsNotDimmedByCoverage) {
    Scene scene;
    Material m = emitter(glm::vec3(2.0f), 1.0f);
    m.alphaMode = AlphaMode::blend;
    m.baseColor.w = 0.25f;
    place(scene, quad(1.0f, addMaterial(scene, m)));
    const Frame frame = renderer().render(request(std::move(scene), "emissive veil"));
    expectNear(centerColor(frame.image), glm::vec3(2.0f), 1e-3f);
}

TEST_F(Emission, IsAddedToReflectedLight) {
    Scene dark, glowing;
    const Material plain{.baseColor = {0.5f, 0.4f, 0.3f, 1}, .metallic = 0.0f};
    Material lamp = plain;
    lamp.emissive = {0.1f, 0.2f, 0.3f};
    place(dark, quad(1.0f, addMaterial(dark, plain)));
    place(glowing, quad(1.0f, addMaterial(glowing, lamp)));
    FrameRequest off = request(std::move(dark), "dark"), on = request(std::move(glowing), "glow");
    off.environment.map = on.environment.map = "white";
    const glm::vec3 difference =
        centerColor(renderer().render(on).image) - centerColor(renderer().render(off).image);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(difference[c], lamp.emissive[c], 1e-6f);
}

TEST_F(Emission, TheSwitchChangesNothingElse) {
    Scene scene;
    const Index lamp = addMaterial(scene, emitter({1, 1, 1}, 3.0f));
    const Index wall = addMaterial(scene, {.baseColor = {0.5f, 0.6f, 0.7f, 1}, .metallic = 0.0f});
    place(scene, quad(0.5f, lamp), moved(-0.8, 0, 0));
    place(scene, quad(0.5f, wall), moved(0.8, 0, 0));
    FrameRequest r = request(std::move(scene), "switch");
    r.environment.map = "sky";
    const Image on = renderer().render(r).image;
    r.effects.emission = false;
    const Image off = renderer().render(r).image;
    std::size_t changed = 0;
    for (std::uint32_t y = 0; y < on.height; ++y) {
        for (std::uint32_t x = 0; x < on.width; ++x) {
            const bool inLamp = x >= 10 && x < 28 && y >= 22 && y < 42;
            if (color(on, x, y) == color(off, x, y)) continue;
            ++changed;
            EXPECT_TRUE(inLamp) << x << " " << y;
        }
    }
    EXPECT_GT(changed, 200u);
}
