#include "tests/stability/random_scenes.h"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace clerestory::test {
namespace {

template <class T, std::size_t N>
T oneOf(RandomSource& chance, const std::array<T, N>& values) {
    return values[chance.below(static_cast<std::uint32_t>(N))];
}

Material randomMaterial(RandomSource& chance) {
    const std::array roughnesses{0.0f, 0.01f, 0.05f, 0.2f, 0.45f, 0.5f, 0.7f, 1.0f};
    Material m{.name = "material" + std::to_string(chance.below(6))};
    m.baseColor = glm::vec4(glm::vec3(chance.inBox(0.5) + 0.5), 1.0f);
    m.roughness = oneOf(chance, roughnesses);
    m.metallic = 0.0f;
    m.doubleSided = chance.is(0.5);
    switch (chance.below(5)) {
        case 0:  // lamp
            m.emissive = glm::vec3(chance.inBox(0.5) + 0.5);
            m.emissiveStrength = oneOf(chance, std::array{1.0f, 10.0f, 1e4f});
            break;
        case 1:  // mirror
            m.metallic = oneOf(chance, std::array{0.5f, 1.0f});
            break;
        case 2:  // glass
            m.transmission = oneOf(chance, std::array{0.3f, 1.0f});
            m.ior = oneOf(chance, std::array{1.0f, 1.0003f, 1.33f, 1.5f, 3.0f});
            m.thickness = oneOf(chance, std::array{0.0f, 0.05f, 1.0f});
            m.attenuationDistance = oneOf(chance, std::array{0.0f, 0.1f, 2.0f});
            m.attenuationColor = glm::vec3(chance.inBox(0.5) + 0.5);
            break;
        default:
            break;
    }
    return m;
}

glm::dmat4 randomPlace(RandomSource& chance) {
    glm::dmat4 m = glm::translate(glm::dmat4(1.0), chance.inBox(1.2));
    m = glm::rotate(m, chance.real(0.0, 6.3), chance.direction());
    if (chance.is(0.2)) {
        const std::array factors{-1.0, 0.0, 1e-6, 0.01, 3.0, 1e4};
        glm::dvec3 scale(1.0);
        scale[static_cast<int>(chance.below(3))] = oneOf(chance, factors);
        m = glm::scale(m, scale);
    }
    return m;
}

// Six mirrors or walls about the origin, facing inwards, of materials that `next` makes.
template <class Next>
void addWalls(Scene& scene, double half, const Next& next) {
    for (int axis = 0; axis < 3; ++axis) {
        for (const double side : {-1.0, 1.0}) {
            glm::dmat4 m(0.0);
            m[0][(axis + 1) % 3] = -side;
            m[1][(axis + 2) % 3] = 1.0;
            m[2][axis] = -side;
            m[3] = glm::dvec4(0, 0, 0, 1);
            m[3][axis] = side * half;
            place(scene, quad(float(half), addMaterial(scene, next())), m);
        }
    }
}

void addRoom(Scene& scene, RandomSource& chance, double half) {
    addWalls(scene, half, [&] { return randomMaterial(chance); });
    for (int i = 0; i < 2; ++i) {  // in a corner, at the wall, or in it
        const double at = oneOf(chance, std::array{0.999, 0.5, 1.0, 1.001}) * half;
        scene.probes.push_back({.name = "corner" + std::to_string(i),
                                .node = addNode(scene, "corner", moved(i == 0 ? at : -at, at, -at)),
                                .size = chance.real(1e-3, 2.0),
                                .resolution = 16});
    }
}

}  // namespace

std::uint64_t RandomSource::bits() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
}
double RandomSource::real(double low, double high) {
    return low + (high - low) * double(bits() >> 11) * 0x1p-53;
}
std::uint32_t RandomSource::below(std::uint32_t end) {
    return static_cast<std::uint32_t>(bits() % end);
}
glm::dvec3 RandomSource::inBox(double half) {
    const double x = real(-half, half), y = real(-half, half);
    return {x, y, real(-half, half)};
}
glm::dvec3 RandomSource::direction() {
    const double z = real(-1.0, 1.0), turn = real(0.0, 6.283185307179586);
    const double r = std::sqrt(std::max(0.0, 1.0 - z * z));
    return {r * std::cos(turn), r * std::sin(turn), z};
}

Scene randomScene(RandomSource& chance, const std::string& id) {
    Scene scene;
    scene.id = id;
    scene.environment = oneOf(chance, std::array<const char*, 3>{"grey", "dusk", "black"});
    if (chance.is(0.4)) addRoom(scene, chance, 2.0);
    const std::uint32_t things = chance.below(8);
    for (std::uint32_t i = 0; i < things; ++i) {
        const glm::dmat4 at = randomPlace(chance);
        const std::uint32_t kind = chance.below(4);
        if (kind == 0) {  // one in the other
            for (const float radius : {0.5f, 0.3f, 0.1f}) {
                place(scene, sphere(radius, 6, addMaterial(scene, randomMaterial(chance))), at);
            }
        } else if (kind == 1) {  // one before the other
            const Index m = addMaterial(scene, randomMaterial(chance));
            place(scene, quad(0.6f, m), at);
            place(scene, quad(0.6f, m),
                  glm::rotate(at * moved(0, 0, chance.real(0.0, 0.5)), 3.141592653589793,
                              glm::dvec3(0, 1, 0)));
        } else if (kind == 2) {
            place(scene, sphere(0.4f, 6, addMaterial(scene, randomMaterial(chance))), at);
        } else {
            place(scene, quad(0.5f, addMaterial(scene, randomMaterial(chance))), at);
        }
    }
    if (chance.is(0.5)) {
        addLight(scene,
                 {.kind = oneOf(chance, std::array{LightKind::point, LightKind::directional,
                                                   LightKind::spot})},
                 randomPlace(chance));
    }
    updateContentHash(scene);
    return scene;
}

Scene randomPlainScene(RandomSource& chance, const std::string& id, bool smooth) {
    Scene scene;
    scene.id = id;
    scene.environment = oneOf(chance, std::array<const char*, 2>{"grey", "dusk"});
    const bool glass = chance.is(0.5), solids = chance.is(0.5);
    const auto next = [&](double special) {
        Material m{.name = "plain", .metallic = 0.0f, .roughness = 1.0f};
        m.baseColor = glm::vec4(glm::vec3(chance.inBox(0.4) + 0.5), 1.0f);
        if (chance.is(special)) {
            m.roughness =
                smooth ? oneOf(chance, std::array{0.0f, 0.01f}) : float(chance.real(0.1, 0.3));
            if (glass) {
                m.transmission = 1.0f;
                m.ior = oneOf(chance, std::array{1.33f, 1.5f});
                m.doubleSided = true;
            } else {
                m.metallic = 1.0f;
            }
        } else if (chance.is(0.3)) {
            m.emissive = glm::vec3(chance.inBox(0.5) + 0.5);
            m.emissiveStrength = glass ? 1.0f : oneOf(chance, std::array{1.0f, 10.0f});
        }
        return m;
    };
    if (chance.is(0.6)) addWalls(scene, 2.0, [&] { return next(glass ? 0.0 : 0.2); });
    std::vector<glm::dvec3> places;
    for (int tries = 0; tries < 12 && places.size() < 5; ++tries) {
        const glm::dvec3 at = chance.inBox(1.4);
        const glm::dmat4 m = glm::rotate(glm::translate(glm::dmat4(1.0), at), chance.real(0.0, 6.3),
                                         chance.direction());
        const auto near = [&](const glm::dvec3& other) { return glm::distance(at, other) < 1.6; };
        if (std::any_of(places.begin(), places.end(), near)) continue;
        places.push_back(at);
        Material material = next(0.6);
        if (material.transmission > 0.0f ? solids : chance.is(0.5)) {
            if (material.transmission > 0.0f) material.thickness = 0.8f;
            place(scene, sphere(0.4f, 16, addMaterial(scene, material)), m);
        } else {
            place(scene, quad(0.5f, addMaterial(scene, material)), m);
        }
    }
    if (chance.is(0.5)) addLight(scene, {.kind = LightKind::directional}, randomPlace(chance));
    updateContentHash(scene);
    return scene;
}

namespace {

// Injective over every frame.
LensRequest randomLens(RandomSource& chance) {
    switch (chance.below(4)) {
        case 0:
            return EquirectangularLens{chance.real(0.01, 6.28), chance.real(0.01, 3.14)};
        case 1:
            return CubeLens{static_cast<CubeLayout>(chance.below(3))};
        case 2:
            return FisheyeLens{.fov = chance.real(0.02, 6.28), .k1 = chance.real(0.0, 0.1)};
        default:
            return PerspectiveLens{.k1 = chance.real(0.0, 0.5), .k2 = chance.real(0.0, 0.2)};
    }
}

}  // namespace

void randomCamera(RandomSource& chance, FrameRequest& request) {
    request.camera = {};
    const glm::dvec3 eye = chance.is(0.1)
                               ? chance.direction() * std::pow(10.0, chance.real(-6.0, 6.0))
                               : chance.inBox(2.2);
    request.camera.position = eye;
    request.camera.target =
        chance.is(0.1) ? eye + glm::dvec3(0, chance.is(0.5) ? 1 : -1, 0) : eye + chance.direction();
    if (chance.is(0.3)) request.camera.up = chance.direction();
    if (chance.is(0.5)) request.camera.yfov = glm::radians(chance.real(1.0, 179.0));
    if (chance.is(0.3)) request.camera.znear = std::pow(10.0, chance.real(-7.0, 0.0));
    if (chance.is(0.1)) request.camera.zfar = std::pow(10.0, chance.real(0.5, 6.0));
    if (chance.is(0.15) && !request.camera.yfov) request.camera.lens = randomLens(chance);
}

FrameRequest randomRequest(RandomSource& chance, const std::string& scene) {
    FrameRequest r;
    r.scene = scene;
    r.width = 1 + chance.below(24);
    r.height = 1 + chance.below(24);
    randomCamera(chance, r);
    r.effects = {chance.is(0.9), chance.is(0.9), chance.is(0.9), chance.is(0.9)};
    r.effects.shadows = r.effects.indirectLight = false;  // as the ladder's other ways to a picture

    r.accuracy = accuracyOf(oneOf(chance, std::array{Preset::draft, Preset::standard}));
    Accuracy& a = r.accuracy;
    a.environmentSize = 16;
    a.environmentSamples = 4;
    a.probeSize = 16;
    a.probeSamples = oneOf(chance, std::array{1u, 4u});
    a.edgeFilter = false;
    a.generations = 1 + chance.below(3);
    a.bounces = 1 + chance.below(8);
    if (a.bounces == 8) a.raySamples = a.glassRaySamples = 3;
    a.planarScale = oneOf(chance, std::array{0.125, 0.3, 1.0});
    a.planarSamples = oneOf(chance, std::array{1u, 1u, 4u});
    a.curvedSamples = oneOf(chance, std::array{0u, 0u, 4u});
    a.backFaces = chance.is(0.3);
    a.samples = oneOf(chance, std::array{1u, 1u, 4u});
    a.parallax = oneOf(chance, std::array{Parallax::none, Parallax::box, Parallax::depth});
    a.planar = oneOf(chance, std::array{PlanarMethod::automatic, PlanarMethod::environment,
                                        PlanarMethod::mirror, PlanarMethod::traced});
    a.curved = oneOf(chance, std::array{CurvedMethod::automatic, CurvedMethod::environment,
                                        CurvedMethod::probe, CurvedMethod::traced});
    a.glass = oneOf(chance, std::array{GlassMethod::automatic, GlassMethod::environment,
                                       GlassMethod::backdrop, GlassMethod::traced});
    r.environment.visible = chance.is(0.9);
    r.exposure = chance.real(-4.0, 4.0);
    r.output.format = OutputFormat::npy;
    return r;
}

}  // namespace clerestory::test
