// A meadow in the sun: a flag, a fox that walks around a mirror ball, lanterns in orbit around the
// ball, and a tall mirror behind them.
#include "scene/builtin/meadow_parts.h"

#include "scene/builtin/builtin_scenes.h"
#include "scene/builtin/modelling.h"
#include "scene/builtin/motion.h"

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <array>
#include <cmath>

namespace clerestory::meadow_parts {
namespace {

// A flag in the wind: waves travel from the pole outwards. A travelling wave is the sum of two
// standing ones, sin(kx - wt) = sin(kx) cos(wt) - cos(kx) sin(wt), so each has two morph targets
// with periodic weights. The cloth moves along its normal only, so its normals are linear in the
// weights as well.

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
        return shapes::GridPoint{{0.04f + kWidth * u, kHeight * (1.0f - v) + sag, 0.0f},
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

namespace clerestory {
namespace {

Index add(Scene& scene, Material material) {
    scene.materials.push_back(std::move(material));
    return static_cast<Index>(scene.materials.size() - 1);
}

void addGround(Scene& scene) {
    Material grass{.name = "grass", .metallic = 0.0f, .roughness = 0.95f, .specular = 0.3f};
    grass.baseColorTexture.texture =
        textures::add(scene, "grass", 512, 512, ColorSpace::srgb, [](float u, float v) {
            const float slow = textures::noise(u, v, 5, 4, 7);
            const float blades = textures::noise(u, v, 90, 2, 8);
            const glm::vec3 tone =
                glm::mix(glm::vec3(0.24f, 0.40f, 0.13f), glm::vec3(0.46f, 0.55f, 0.20f),
                         0.75f * slow + 0.25f * blades);
            return glm::vec4(tone * (0.75f + 0.45f * blades), 1.0f);
        });
    grass.baseColorTexture.scale = glm::vec2(1.0f / 5.0f);
    MeshDraft ground = shapes::draft("meadow", add(scene, grass));
    shapes::addPatch(ground, {-30, 0, 30}, {60, 0, 0}, {0, 0, -60}, 12, 12);
    shapes::addToScene(scene, std::move(ground));

    Material sand{.name = "sand", .metallic = 0.0f, .roughness = 0.95f, .specular = 0.3f};
    sand.baseColorTexture.texture =
        textures::add(scene, "sand", 256, 256, ColorSpace::srgb, [](float u, float v) {
            const float n =
                0.6f * textures::noise(u, v, 6, 4, 17) + 0.4f * textures::noise(u, v, 64, 2, 18);
            return glm::vec4(
                glm::mix(glm::vec3(0.60f, 0.50f, 0.36f), glm::vec3(0.80f, 0.72f, 0.56f), n), 1.0f);
        });
    sand.baseColorTexture.scale = glm::vec2(1.0f / 2.0f);
    MeshDraft path = shapes::draft("path", add(scene, sand));
    shapes::addGrid(path, 96, 2, {13.0f, 0.8f}, [](float u, float v) {
        const float angle = glm::two_pi<float>() * u;
        const float edge = 0.03f * std::sin(7.0f * angle) + 0.02f * std::sin(13.0f * angle);
        const float radius =
            static_cast<float>(meadow_parts::kPathRadius) + (v - 0.5f) * (0.75f + edge);
        return shapes::GridPoint{{radius * std::sin(angle), 0.006f, radius * std::cos(angle)},
                                    {0, 1, 0}};
    });
    shapes::addToScene(scene, std::move(path));
}

void addBall(Scene& scene) {
    const Index stone = add(scene, {.name = "stone",
                                    .baseColor = {0.55f, 0.53f, 0.50f, 1.0f},
                                    .metallic = 0.0f,
                                    .roughness = 0.85f});
    MeshDraft plinth = shapes::draft("plinth", stone);
    const std::vector<glm::vec2> section{{0.42f, 0.0f},  {0.42f, 0.10f}, {0.30f, 0.16f},
                                         {0.24f, 0.48f}, {0.34f, 0.56f}, {0.34f, 0.62f},
                                         {0.0f, 0.62f}};
    shapes::addLathe(plinth, {}, section, 48);
    shapes::addToScene(scene, std::move(plinth));
    const Index mirror = add(
        scene,
        {.name = "polished metal", .baseColor = {0.96f, 0.95f, 0.94f, 1.0f}, .roughness = 0.0f});
    MeshDraft ball = shapes::draft("mirrored ball", mirror);
    shapes::addSphere(ball, {}, 0.62f, 96);
    shapes::addToScene(scene, std::move(ball), glm::translate(glm::dmat4(1.0), {0, 1.22, 0}));
}

void addStandingMirror(Scene& scene) {
    const glm::dmat4 stands =
        glm::rotate(glm::translate(glm::dmat4(1.0), {-1.1, 0.0, -3.6}), -0.03, glm::dvec3(0, 1, 0));
    const Index wood = add(scene, {.name = "oak",
                                   .baseColor = {0.34f, 0.20f, 0.10f, 1.0f},
                                   .metallic = 0.0f,
                                   .roughness = 0.6f});
    MeshDraft frame = shapes::draft("frame", wood);
    shapes::addBox(frame, {-2.5f, 0.0f, -0.12f}, {-2.35f, 3.8f, 0.08f});
    shapes::addBox(frame, {2.35f, 0.0f, -0.12f}, {2.5f, 3.8f, 0.08f});
    shapes::addBox(frame, {-2.35f, 0.20f, -0.12f}, {2.35f, 0.34f, 0.08f});
    shapes::addBox(frame, {-2.35f, 3.66f, -0.12f}, {2.35f, 3.8f, 0.08f});
    shapes::addBox(frame, {-2.35f, 0.34f, -0.12f}, {2.35f, 3.66f, -0.04f});
    shapes::addToScene(scene, std::move(frame), stands);
    const Index silver = add(
        scene,
        {.name = "silvered glass", .baseColor = {0.93f, 0.94f, 0.94f, 1.0f}, .roughness = 0.0f});
    MeshDraft pane = shapes::draft("mirror", silver);
    shapes::addPatch(pane, {-2.35f, 0.34f, 0.0f}, {4.7f, 0, 0}, {0, 3.32f, 0});
    shapes::addToScene(scene, std::move(pane), stands);
}

// Paper lanterns in a common orbit around the ball, each with its own vertical motion.
void addLanterns(Scene& scene) {
    constexpr double kRound = 12.0, kBob = 3.0;  // seconds
    const Index wheel = addNode(scene, "lanterns");
    const Index wheelMoves = motion::addMovingNode(scene, wheel, {});
    Clip circling{"lanterns", kRound, {motion::turning(scene, wheelMoves, {0, 1, 0}, -1, kRound)}};
    const std::array<glm::vec3, 5> colors{{{0.85f, 0.13f, 0.10f},
                                           {0.95f, 0.62f, 0.08f},
                                           {0.16f, 0.55f, 0.32f},
                                           {0.12f, 0.38f, 0.80f},
                                           {0.62f, 0.20f, 0.62f}}};
    for (std::size_t i = 0; i < colors.size(); ++i) {
        const double angle = glm::two_pi<double>() * double(i) / double(colors.size());
        const std::string name = "lantern " + std::to_string(i + 1);
        const Index paper = add(scene, {.name = name,
                                        .baseColor = glm::vec4(colors[i], 1.0f),
                                        .metallic = 0.0f,
                                        .roughness = 0.7f});
        MeshDraft lantern = shapes::draft(name, paper);
        const std::vector<glm::vec2> section{{0.0f, -0.17f},  {0.07f, -0.17f}, {0.07f, -0.15f},
                                             {0.15f, -0.09f}, {0.18f, 0.0f},   {0.15f, 0.09f},
                                             {0.07f, 0.15f},  {0.07f, 0.17f},  {0.0f, 0.17f}};
        shapes::addLathe(lantern, {}, section, 28, 0.9f);
        const glm::dvec3 at(1.25 * std::sin(angle), 2.15, 1.25 * std::cos(angle));
        const Index node = addNode(scene, name, glm::dmat4(1.0), wheel);
        const Index moves = motion::addMovingNode(scene, node, {.translation = at});
        addInstance(scene, node, addMesh(scene, std::move(lantern)));
        circling.tracks.push_back(
            motion::repeating(AnimatedProperty::translation, moves, kRound, 32, [&](double t) {
                const double turn = glm::two_pi<double>() * t / kBob + 2.5 * double(i);
                return motion::numbers(at + glm::dvec3(0.0, 0.13 * std::sin(turn), 0.0));
            }));
    }
    scene.clips.push_back(std::move(circling));
}

}  // namespace

Scene meadow() {
    Scene scene;
    scene.environment = "sky";
    addGround(scene);
    addBall(scene);
    addStandingMirror(scene);
    meadow_parts::addFlag(scene, {-4.1, 0.0, -0.6});
    meadow_parts::addFox(scene);
    addLanterns(scene);
    scene.defaultView = DefaultView{{-0.7, 2.1, 6.8}, {-0.85, 1.5, -0.6}, 0.74};
    finishMotion(scene);
    return scene;
}

}  // namespace clerestory
