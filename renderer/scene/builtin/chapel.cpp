// The chapel: lights, cameras and construction.
#include "scene/builtin/builtin_scenes.h"
#include "scene/builtin/chapel_parts.h"

#include <glm/gtc/matrix_transform.hpp>

#include <cmath>

namespace clerestory {
namespace {

void addCamera(Scene& scene, const std::string& name, const glm::dvec3& position,
               const glm::dvec3& target, double yfov) {
    const glm::dmat4 m = glm::inverse(glm::lookAt(position, target, glm::dvec3(0, 1, 0)));
    scene.cameras.push_back(
        {.name = name, .node = addNode(scene, "camera " + name, m), .yfov = yfov});
}

}  // namespace

namespace chapel_parts {

void addLights(Scene& scene) {
    const auto addPointLight = [&](const std::string& name, const glm::dvec3& at,
                                   const glm::vec3& intensity, float range) {
        scene.lights.push_back({.name = name,
                                .node = addNode(scene, name, glm::translate(glm::dmat4(1.0), at)),
                                .intensity = intensity,
                                .range = range});
    };
    // Above the braziers (see addFurniture), high enough not to over-light the bowls.
    for (const double z : {7.0, -7.0}) {
        for (const double x : {-2.55, 2.55})
            addPointLight("embers", {x, 1.85, z}, {9.0f, 3.9f, 1.15f}, 9.0f);
    }
    for (const double z : {3.0, -3.0})
        addPointLight("chandelier", {0, 5.4, z}, {16.0f, 11.0f, 6.2f}, 15.0f);
    addPointLight("altar candles", {0, 2.3, -9.7}, {9.0f, 6.6f, 4.0f}, 9.0f);

    // Daylight through the clerestory on one side.
    for (const double z : {6.0, -2.0}) {
        const glm::dvec3 from(3.1, 9.0, z), to(-1.2, 0.0, z - 1.5);
        const glm::dmat4 m = glm::inverse(glm::lookAt(from, to, glm::dvec3(0, 1, 0)));
        scene.lights.push_back({.name = "daylight",
                                .node = addNode(scene, "daylight", m),
                                .kind = LightKind::spot,
                                .intensity = glm::vec3(95.0f, 88.0f, 78.0f),
                                .range = 24.0f,
                                .innerConeAngle = 0.12f,
                                .outerConeAngle = 0.42f});
    }
    // Daylight through the rose window, along the nave.
    const glm::dmat4 rose = glm::inverse(
        glm::lookAt(glm::dvec3(0, 9.6, -11.6), glm::dvec3(0, 2.0, 4.0), glm::dvec3(0, 1, 0)));
    scene.lights.push_back({.name = "rose",
                            .node = addNode(scene, "rose light", rose),
                            .kind = LightKind::spot,
                            .intensity = glm::vec3(46.0f, 54.0f, 88.0f),
                            .range = 40.0f,
                            .innerConeAngle = 0.2f,
                            .outerConeAngle = 0.75f});
}

// The view through the open door: a terrace, a low wall and cypresses.
void addOutside(Scene& scene, const Materials& m) {
    using namespace shapes;
    constexpr float kNear = kAisle, kFar = kAisle + 8.0f;

    MeshDraft terrace = draft("terrace", m.paving);
    addPatch(terrace, {kNear, 0.0f, kDoorZ + 16.0f}, {kFar - kNear, 0, 0}, {0, 0, -48.0f}, 8, 16);
    // The wall of the chapel hides half of the sky.
    shadeFrom(terrace, 0, [](const Vertex& v) {
        return 1.0f - 0.55f * std::exp(-(v.position.x - kNear) / 2.5f);
    });
    addBox(terrace, {kFar - 0.4f, 0.0f, kDoorZ - 32.0f}, {kFar, 0.7f, kDoorZ + 16.0f});
    addToScene(scene, std::move(terrace));

    MeshDraft trees = draft("cypresses", m.leaves);
    struct Tree {
        float x, z, height;
    };
    // Two of them are visible from the nave's camera through the door.
    const Tree row[] = {{1.5f, -12.4f, 4.9f}, {2.0f, -15.2f, 6.2f}, {1.5f, -19.0f, 6.0f},
                        {2.2f, -7.5f, 6.6f},  {1.5f, -2.5f, 5.4f},  {2.0f, 3.0f, 6.4f}};
    for (const Tree& tree : row) {
        std::vector<glm::vec2> profile;
        constexpr int kSteps = 14;
        for (int i = 0; i <= kSteps; ++i) {
            const float t = static_cast<float>(i) / kSteps;
            // The outline of a flame, with noise.
            const float width = 0.9f * std::pow(t, 0.4f) * std::pow(1.0f - t, 0.75f) *
                                (1.0f + 0.10f * std::sin(19.0f * t + tree.z));
            profile.emplace_back(width, 0.05f + tree.height * t);
        }
        addLathe(trees, {kFar + tree.x, 0.0f, kDoorZ + tree.z}, profile, 10);
    }
    addToScene(scene, std::move(trees));
}

}  // namespace chapel_parts

Scene chapel() {
    Scene scene;
    scene.environment = "dusk";
    const chapel_parts::Materials materials = chapel_parts::addMaterials(scene);
    chapel_parts::addMasonry(scene, materials);
    chapel_parts::addOutside(scene, materials);
    chapel_parts::addFurniture(scene, materials);
    chapel_parts::addLights(scene);
    addCamera(scene, "nave", {0.5, 1.75, 11.4}, {-0.05, 3.9, -4.0}, 1.0);
    addCamera(scene, "altar", {1.6, 1.7, -4.2}, {-0.2, 2.6, -11.0}, 0.95);
    addCamera(scene, "figure", {-0.4, 1.75, 8.0}, {-2.1, 1.65, 4.6}, 0.75);
    addCamera(scene, "window", {-1.0, 3.2, -4.6}, {0.0, 8.6, -12.0}, 0.9);
    addCamera(scene, "aisle", {5.9, 1.7, 6.6}, {3.0, 2.9, -6.0}, 1.0);
    scene.defaultView = DefaultView{{0.5, 1.75, 11.4}, {-0.05, 3.9, -4.0}, 1.0};
    return scene;
}

}  // namespace clerestory
