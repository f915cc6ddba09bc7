#include "scene/builtin/builtin_scenes.h"

#include "scene/builtin/modelling.h"
#include "scene/builtin/motion.h"

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace clerestory {
namespace {

Index addPlain(Scene& scene, Material material) {
    scene.materials.push_back(std::move(material));
    return static_cast<Index>(scene.materials.size() - 1);
}

Index metal(Scene& scene, std::string name, const glm::vec3& color, float roughness) {
    return addPlain(scene, {.name = std::move(name),
                            .baseColor = glm::vec4(color, 1.0f),
                            .metallic = 1.0f,
                            .roughness = roughness});
}

Index dielectric(Scene& scene, std::string name, const glm::vec3& color, float roughness) {
    return addPlain(scene, {.name = std::move(name),
                            .baseColor = glm::vec4(color, 1.0f),
                            .metallic = 0.0f,
                            .roughness = roughness});
}

void addPointLight(Scene& scene, std::string name, const glm::dvec3& position,
                   const glm::vec3& intensity) {
    const Index node = addNode(scene, name, glm::translate(glm::dmat4(1.0), position));
    scene.lights.push_back({.name = std::move(name), .node = node, .intensity = intensity});
}

// Planks or slabs: low-frequency noise between two colours.
Index mottled(Scene& scene, std::string name, const glm::vec3& a, const glm::vec3& b,
              std::uint32_t seed) {
    return textures::add(scene, std::move(name), 256, 256, ColorSpace::srgb, [=](float u, float v) {
        return glm::vec4(glm::mix(a, b, textures::noise(u, v, 4, 5, seed)), 1.0f);
    });
}

// The profile of the teapot's body.
void addTeapot(Scene& scene, const std::string& name, Index material,
               const glm::dmat4& worldFromTeapot) {
    using namespace shapes;
    MeshDraft pot = draft(name, material);
    const std::vector<glm::vec2> body = {{0.00f, 0.02f}, {0.46f, 0.00f}, {0.52f, 0.04f},
                                         {0.66f, 0.16f}, {0.80f, 0.42f}, {0.78f, 0.68f},
                                         {0.64f, 0.90f}, {0.47f, 1.02f}, {0.44f, 1.06f}};
    addLathe(pot, {}, smooth(body, 8), 64, 0.9f);
    const std::vector<glm::vec2> lid = {{0.45f, 1.05f}, {0.43f, 1.10f}, {0.28f, 1.20f},
                                        {0.10f, 1.26f}, {0.06f, 1.31f}, {0.11f, 1.38f},
                                        {0.08f, 1.45f}, {0.00f, 1.47f}};
    addLathe(pot, {}, smooth(lid, 8), 48, 0.9f);
    const std::vector<glm::vec3> spout = {{0.62f, 0.34f, 0},
                                          {0.92f, 0.42f, 0},
                                          {1.10f, 0.70f, 0},
                                          {1.20f, 0.98f, 0},
                                          {1.34f, 1.10f, 0}};
    addTube(
        pot, smooth(spout, 10), [](float t) { return 0.17f - 0.10f * t; }, 24);
    const std::vector<glm::vec3> handle = {{-0.60f, 0.92f, 0}, {-0.92f, 1.00f, 0},
                                           {-1.14f, 0.80f, 0}, {-1.10f, 0.50f, 0},
                                           {-0.88f, 0.34f, 0}, {-0.70f, 0.30f, 0}};
    addTube(
        pot, smooth(handle, 10), [](float) { return 0.065f; }, 20);
    addToScene(scene, std::move(pot), worldFromTeapot);
}

struct Entry {
    BuiltinScene scene;
    Scene (*make)();
};

const std::vector<Entry>& entries() {
    static const std::vector<Entry> list = {
        {{"chapel", "Chapel"}, chapel},
        {{"six-walls", "Six walls"}, sixWalls},
        {{"orbiting-cubes", "Orbiting cubes"}, orbitingCubes},
        {{"teapots", "Teapots"}, teapots},
        {{"meadow", "Meadow"}, meadow},
    };
    return list;
}

}  // namespace

Scene sixWalls() {
    Scene scene;
    scene.environment = "black";
    const float h = kSixWallsHalf;
    const char* names[] = {"wall +X", "wall -X", "wall +Y", "wall -Y", "wall +Z", "wall -Z"};
    for (int i = 0; i < 6; ++i) {
        const int axis = i / 2;
        const float side = i % 2 == 0 ? 1.0f : -1.0f;
        // Black and without reflection, so that a wall shows only its emission.
        const Index material =
            addPlain(scene, {.name = names[i],
                             .baseColor = {0, 0, 0, 1},
                             .metallic = 0.0f,
                             .emissive = kSixWallsRadiance[static_cast<std::size_t>(i)],
                             .specular = 0.0f});
        glm::vec3 corner(-h), u(0.0f), v(0.0f);
        corner[axis] = side * h;
        u[(axis + 1) % 3] = 2.0f * h;
        v[(axis + 2) % 3] = 2.0f * h;
        MeshDraft wall = shapes::draft(names[i], material);
        if (side > 0.0f)
            shapes::addPatch(wall, corner, v, u);  // the front faces inwards
        else
            shapes::addPatch(wall, corner, u, v);
        shapes::addToScene(scene, std::move(wall));
    }
    MeshDraft ball = shapes::draft("ball", metal(scene, "mirror", glm::vec3(1.0f), 0.0f));
    shapes::addSphere(ball, {}, 0.5f, 96);
    shapes::addToScene(scene, std::move(ball));
    scene.defaultView = DefaultView{{1.2, 0.7, 1.6}, {0, 0, 0}, 1.2};
    return scene;
}

Scene orbitingCubes() {
    Scene scene;
    scene.environment = "sky";
    Material ground{.name = "floor", .metallic = 0.0f, .roughness = 0.25f};
    ground.baseColorTexture.texture =
        textures::add(scene, "tiles", 512, 512, ColorSpace::srgb, [](float u, float v) {
            const int x = static_cast<int>(u * 8.0f), y = static_cast<int>(v * 8.0f);
            const float fleck = 0.08f * (textures::noise(u, v, 16, 4, 5) - 0.5f);
            const glm::vec3 tone =
                (x + y) % 2 ? glm::vec3(0.86f, 0.84f, 0.80f) : glm::vec3(0.33f, 0.36f, 0.40f);
            return glm::vec4(tone + fleck, 1.0f);
        });
    ground.baseColorTexture.scale = glm::vec2(1.0f / 4.0f);
    MeshDraft floor = shapes::draft("floor", addPlain(scene, ground));
    shapes::addPatch(floor, {-12, 0, 12}, {24, 0, 0}, {0, 0, -24}, 24, 24);
    shapes::addToScene(scene, std::move(floor));

    MeshDraft ball =
        shapes::draft("mirrored ball", metal(scene, "mirror", {0.97f, 0.96f, 0.95f}, 0.0f));
    shapes::addSphere(ball, {}, 1.0f, 128);
    shapes::addToScene(scene, std::move(ball), glm::translate(glm::dmat4(1.0), {0, 1.25, 0}));

    // Every second one grows while the others shrink; at time 0 all have the same size.
    constexpr double kOrbit = 16.0, kPulse = 2.0;  // seconds
    const Index wheel = addNode(scene, "wheel");
    Clip orbit{
        "orbit",
        kOrbit,
        {motion::turning(scene, motion::addMovingNode(scene, wheel, {}), {0, 1, 0}, 1, kOrbit)}};
    Clip pulse{"pulse", kPulse, {}};
    const glm::vec3 colors[8] = {
        {0.80f, 0.10f, 0.08f}, {0.90f, 0.42f, 0.05f}, {0.92f, 0.76f, 0.10f}, {0.25f, 0.62f, 0.16f},
        {0.08f, 0.55f, 0.55f}, {0.10f, 0.28f, 0.75f}, {0.40f, 0.16f, 0.66f}, {0.80f, 0.20f, 0.50f}};
    for (int i = 0; i < 8; ++i) {
        const double angle = glm::two_pi<double>() * i / 8.0;
        const std::string name = "cube " + std::to_string(i + 1);
        MeshDraft cube = shapes::draft(name, dielectric(scene, name, colors[i], 0.35f));
        shapes::addBox(cube, glm::vec3(-0.4f), glm::vec3(0.4f));
        const glm::dquat turned = glm::angleAxis(angle, glm::dvec3(0, 1, 0));
        const Index node = addNode(scene, name, glm::dmat4(1.0), wheel);
        const Index moves = motion::addMovingNode(
            scene, node,
            {.translation = turned * glm::dvec3(0, 0.9 + 0.35 * (i % 2), 2.6), .rotation = turned});
        addInstance(scene, node, addMesh(scene, std::move(cube)));
        pulse.tracks.push_back(
            motion::repeating(AnimatedProperty::scale, moves, kPulse, 16, [i](double t) {
                const double swing = 0.35 * std::sin(glm::two_pi<double>() * t / kPulse);
                return motion::numbers(glm::dvec3(1.0 + (i % 2 ? -swing : swing)));
            }));
    }
    scene.clips = {orbit, pulse};
    finishMotion(scene);
    scene.defaultView = DefaultView{{4.2, 3.0, 5.6}, {0, 0.9, 0}, 0.75};
    return scene;
}

Scene teapots() {
    Scene scene;
    scene.environment = "studio";
    Material wood{.name = "table", .metallic = 0.0f, .roughness = 0.42f};
    wood.baseColorTexture.texture =
        textures::add(scene, "wood", 512, 256, ColorSpace::srgb, [](float u, float v) {
            // Wood grain: bands across v, distorted by low-frequency noise.
            const float bend = textures::noise(u, v, 3, 3, 11);
            const float band = std::abs(std::fmod(14.0f * (v + 0.18f * bend), 1.0f) - 0.5f) * 2.0f;
            const float grain = textures::noise(u * 0.25f, v * 4.0f, 16, 4, 12);
            const glm::vec3 tone =
                glm::mix(glm::vec3(0.36f, 0.22f, 0.13f), glm::vec3(0.58f, 0.39f, 0.24f),
                         0.6f * band + 0.4f * grain);
            return glm::vec4(tone, 1.0f);
        });
    wood.baseColorTexture.scale = glm::vec2(1.0f / 5.0f);
    MeshDraft table = shapes::draft("table", addPlain(scene, wood));
    shapes::addBox(table, {-6.0f, -0.3f, -3.2f}, {6.0f, 0.0f, 3.0f});
    shapes::addToScene(scene, std::move(table));

    Material glazed{.name = "porcelain", .metallic = 0.0f, .roughness = 0.12f};
    glazed.baseColorTexture.texture =
        mottled(scene, "porcelain", {0.93f, 0.93f, 0.90f}, {0.86f, 0.89f, 0.93f}, 21);
    Material glass{.name = "glass",
                   .baseColor = {0.80f, 0.95f, 0.90f, 1.0f},
                   .metallic = 0.0f,
                   .roughness = 0.02f,
                   .ior = 1.5f,
                   .transmission = 1.0f,
                   .thickness = 0.06f};
    const Index stuff[] = {
        addPlain(scene, glazed), metal(scene, "copper", {0.95f, 0.60f, 0.42f}, 0.22f),
        addPlain(scene, glass), metal(scene, "gold", {1.00f, 0.72f, 0.29f}, 0.08f),
        dielectric(scene, "clay", {0.48f, 0.18f, 0.11f}, 0.75f)};
    const glm::dvec3 positions[] = {
        {-3.6, 0, 0.2}, {-1.5, 0, -1.5}, {0.2, 0, 0.9}, {1.9, 0, -1.4}, {3.7, 0, 0.4}};
    const double turns[] = {0.5, -0.3, 0.2, -0.7, 0.9};
    for (int i = 0; i < 5; ++i) {
        const glm::dmat4 m =
            glm::rotate(glm::translate(glm::dmat4(1.0), positions[i]), turns[i], {0, 1, 0});
        addTeapot(scene, "teapot " + scene.materials[stuff[i]].name, stuff[i], m);
    }
    addPointLight(scene, "lamp", {2.5, 5.0, 4.0}, glm::vec3(34.0f, 31.0f, 27.0f));
    scene.defaultView = DefaultView{{0.0, 3.1, 8.2}, {0.0, 0.45, -0.2}, 0.72};
    return scene;
}

std::vector<BuiltinScene> builtinScenes() {
    std::vector<BuiltinScene> list;
    for (const Entry& entry : entries()) list.push_back(entry.scene);
    return list;
}

std::optional<Scene> makeBuiltinScene(const std::string& id) {
    for (const Entry& entry : entries()) {
        if (entry.scene.id != id) continue;
        Scene scene = entry.make();
        scene.id = id;
        scene.title = entry.scene.title;
        updateContentHash(scene);
        return scene;
    }
    return std::nullopt;
}

}  // namespace clerestory
