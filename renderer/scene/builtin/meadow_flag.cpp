// A flag in the wind: waves travel from the pole outwards. A travelling wave is the sum of two
// standing ones, sin(kx - wt) = sin(kx) cos(wt) - cos(kx) sin(wt), so each has two morph targets
// with periodic weights. The cloth moves along its normal only, so its normals are linear in the
// weights as well.
#include "scene/builtin/meadow_parts.h"
#include "scene/builtin/motion.h"
#include "scene/builtin/shapes.h"
#include "scene/builtin/textures.h"

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <array>
#include <cmath>

namespace clerestory::meadow_parts {
namespace {

constexpr float kWidth = 1.9f, kHeight = 1.25f;  // metres
constexpr double kDuration = 2.0;                // seconds

struct Wave {
    float alongX, alongY;  // radians a metre
    float height;          // metres at the free end
    int times;             // periods in kDuration
};
constexpr std::array<Wave, 3> kWaves{
    {{4.6f, 1.1f, 0.27f, 2}, {8.7f, -1.9f, 0.085f, 3}, {15.0f, 2.6f, 0.020f, 5}}};

// Amplitude along the flag, 0 at the pole; and its derivative.
float growth(float x) {
    const float s = x / kWidth;
    return s * (0.8f + 0.2f * s);
}
float growthSlope(float x) {
    return (0.8f + 0.4f * x / kWidth) / kWidth;
}

// A standing wave with this phase: the offset and the derivatives in x and y.
MorphDelta standing(const Wave& wave, const glm::vec3& at, float phase) {
    const float angle = wave.alongX * at.x + wave.alongY * at.y + phase;
    const float a = wave.height * growth(at.x);
    const float alongX =
        wave.height * growthSlope(at.x) * std::sin(angle) + a * wave.alongX * std::cos(angle);
    const float alongY = a * wave.alongY * std::cos(angle);
    return {.position = {0, 0, a * std::sin(angle)},
            .normal = {-alongX, -alongY, 0},
            .tangent = {0, 0, alongX}};
}

// Three bands and a rising sun above the middle one.
Index paintedCloth(Scene& scene) {
    return textures::add(scene, "flag", 512, 336, ColorSpace::srgb, [](float u, float v) {
        const glm::vec3 night(0.06f, 0.20f, 0.36f), cream(0.95f, 0.90f, 0.78f),
            field(0.10f, 0.45f, 0.30f), gold(0.93f, 0.66f, 0.14f);
        glm::vec3 tone = v < 0.34f ? night : v < 0.66f ? cream : field;
        const float x = (u - 0.42f) * kWidth / kHeight, y = v - 0.5f;
        const float radius = std::sqrt(x * x + y * y);
        const float ray = std::cos(12.0f * std::atan2(y, x));
        if (radius < 0.17f || (radius > 0.20f && radius < 0.31f && ray > 0.35f)) tone = gold;
        const float weave = 0.03f * (textures::noise(u, v, 96, 2, 3) - 0.5f);
        return glm::vec4(tone + weave, 1.0f);
    });
}

}  // namespace

void addFlag(Scene& scene, const glm::dvec3& foot) {
    scene.materials.push_back({.name = "painted wood",
                               .baseColor = {0.82f, 0.80f, 0.76f, 1.0f},
                               .metallic = 0.0f,
                               .roughness = 0.5f});
    MeshDraft pole = shapes::draft("pole", static_cast<Index>(scene.materials.size() - 1));
    const std::vector<glm::vec2> section{{0.14f, 0.0f},  {0.14f, 0.12f},  {0.045f, 0.18f},
                                         {0.035f, 3.9f}, {0.075f, 3.93f}, {0.0f, 4.02f}};
    shapes::addLathe(pole, {}, section, 32);
    shapes::addToScene(scene, std::move(pole), glm::translate(glm::dmat4(1.0), foot));

    Material cloth{.name = "cloth", .metallic = 0.0f, .roughness = 0.85f, .doubleSided = true};
    cloth.baseColorTexture.texture = paintedCloth(scene);
    scene.materials.push_back(cloth);
    MeshDraft flag = shapes::draft("flag", static_cast<Index>(scene.materials.size() - 1));
    shapes::addGrid(flag, 48, 30, {1.0f, 1.0f}, [](float u, float v) {
        // The top row of the texture is v = 0. The free end is slightly lower.
        const float sag = -0.16f * u * u * u;
        return shapes::SurfacePoint{{0.04f + kWidth * u, kHeight * (1.0f - v) + sag, 0.0f},
                                    {0, 0, 1}};
    });
    std::vector<std::vector<MorphDelta>> targets;
    for (const Wave& wave : kWaves) {
        for (const float phase : {0.0f, 0.5f * glm::pi<float>()}) {
            std::vector<MorphDelta>& target = targets.emplace_back();
            for (const Vertex& v : flag.vertices) {
                target.push_back(standing(wave, v.position, phase));
            }
        }
    }
    const Index node =
        addNode(scene, "flag", glm::translate(glm::dmat4(1.0), foot + glm::dvec3(0.0, 2.55, 0.0)));
    const Index weights = motion::placeMorphing(scene, std::move(flag), node, targets);
    const auto turns = [](double t) {
        std::vector<double> values;
        for (const Wave& wave : kWaves) {
            const double angle = glm::two_pi<double>() * wave.times * t / kDuration;
            values.push_back(std::cos(angle));
            values.push_back(-std::sin(angle));
        }
        return values;
    };
    scene.clips.push_back(
        {"flag",
         kDuration,
         {motion::repeating(AnimatedProperty::weights, weights, kDuration, 80, turns)}});
}

}  // namespace clerestory::meadow_parts
