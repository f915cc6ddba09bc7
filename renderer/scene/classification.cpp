// The rules of classification, and their words.
#include "scene/classification.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace clerestory {
namespace {

// Below this a factor changes no 8-bit picture.
constexpr float kNothing = 1e-3f;

glm::vec4 meanOf(const Scene& scene, const TextureSlot& slot) {
    if (!slot.present()) return glm::vec4(1.0f);
    return scene.images[scene.textures[slot.texture].image].mean;
}

float average(const glm::vec3& c) {
    return (c.x + c.y + c.z) / 3.0f;
}

float reflectanceOf(const Scene& scene, const Material& m, float metallic) {
    const float root = (m.ior - 1.0f) / (m.ior + 1.0f);
    const float dielectric = std::min(1.0f, root * root * m.specular * average(m.specularColor));
    const glm::vec3 base = glm::vec3(m.baseColor) * glm::vec3(meanOf(scene, m.baseColorTexture));
    return glm::mix(dielectric, std::min(1.0f, average(base)), metallic);
}

void setReflectors(const Material& m, MaterialClass& c) {
    const auto both = [&](Reflector flat, Reflector curved, ReflectorReason why) {
        c.onFlat = flat;
        c.onCurved = curved;
        c.whyFlat = c.whyCurved = why;
    };
    const bool metal = c.metallic >= kMirrorMetallic;
    const bool lobe = metal || m.specular > 0.0f;
    if (m.unlit) return both(Reflector::none, Reflector::none, ReflectorReason::unlit);
    if (m.reflection == Reflection::none) {
        return both(Reflector::none, Reflector::none, ReflectorReason::refused);
    }
    if (!lobe) return both(Reflector::none, Reflector::none, ReflectorReason::noLobe);
    if (!m.environmentMap.empty())
        return both(Reflector::curved, Reflector::curved, ReflectorReason::map);
    if (!m.probe.empty()) return both(Reflector::curved, Reflector::curved, ReflectorReason::probe);
    if (m.reflection == Reflection::mirror) {
        return both(Reflector::flat, Reflector::curved, ReflectorReason::asked);
    }
    if (metal) {
        if (c.roughness <= kMirrorRoughness) {
            return both(Reflector::flat, Reflector::curved, ReflectorReason::metal);
        }
        return both(Reflector::none, Reflector::none, ReflectorReason::rough);
    }
    if (c.roughness > kGlossRoughness)
        return both(Reflector::none, Reflector::none, ReflectorReason::dull);
    if (m.alphaMode == AlphaMode::mask) {
        return both(Reflector::none, Reflector::none, ReflectorReason::cutOut);
    }
    both(Reflector::flat, Reflector::none, ReflectorReason::gloss);
    c.whyCurved = ReflectorReason::round;
}

// Whether all of a mesh lies in one plane, or in both sides of it.
bool isSheet(const Scene& scene, const Mesh& mesh) {
    if (mesh.flatPartCount == 0) return false;
    std::uint32_t clusters = 0;
    const FlatPart& first = scene.flatParts[mesh.firstFlatPart];
    // Flat within 1e-4 of a part's diagonal each, so their planes may differ by twice as much.
    const double tolerance = 2e-4 * static_cast<double>(mesh.bounds.diagonal());
    for (std::uint32_t p = 0; p < mesh.flatPartCount; ++p) {
        const FlatPart& part = scene.flatParts[mesh.firstFlatPart + p];
        clusters += part.clusterCount;
        const double side = glm::dot(part.normal, first.normal);
        const double apart = std::abs(first.plane().distance(-part.offset * part.normal));
        if (std::abs(side) < 0.9998 || apart > tolerance) return false;
    }
    return clusters == mesh.clusterCount;
}

Glass glassOf(const Scene& scene, const Material& m, const MaterialClass& c, const Mesh& mesh) {
    if (!c.transmits) return Glass::none;
    return m.thickness > 0.0f && !isSheet(scene, mesh) ? Glass::solid : Glass::pane;
}

template <class... Numbers>
std::string words(const char* format, Numbers... numbers) {
    char text[256];
    std::snprintf(text, sizeof text, format, static_cast<double>(numbers)...);
    return text;
}

}  // namespace

MaterialClass classOf(const Scene& scene, const Material& m) {
    MaterialClass c;
    const glm::vec4 surface = meanOf(scene, m.metallicRoughnessTexture);
    c.metallic = m.metallic * surface.b;
    c.roughness = m.roughness * surface.g;
    c.transmission = m.transmission * meanOf(scene, m.transmissionTexture).r;
    c.reflectance = reflectanceOf(scene, m, c.metallic);
    const glm::vec3 emitted = emittedRadiance(m);
    c.emitter = !m.unlit && std::max({emitted.x, emitted.y, emitted.z}) > 0.0f;
    // Alpha is coverage, never glass (erratum G6); and nothing passes through a metal.
    c.transmits = !m.unlit && c.transmission * (1.0f - c.metallic) > kNothing;
    setReflectors(m, c);
    return c;
}

std::vector<Surface> surfacesOf(const Scene& scene, const MaterialBindings& materials) {
    std::vector<MaterialClass> classes;
    classes.reserve(scene.materials.size() + materials.own.size());
    for (const Material& m : scene.materials) classes.push_back(classOf(scene, m));
    for (const Material& m : materials.own) classes.push_back(classOf(scene, m));

    std::vector<Surface> surfaces;
    surfaces.reserve(scene.instances.size());
    for (Index i = 0; i < scene.instances.size(); ++i) {
        const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
        const Index material = materials.materialOf(scene, i);
        const MaterialClass& c = classes[material];
        Surface rest{.instance = i,
                     .material = material,
                     .firstCluster = mesh.firstCluster,
                     .clusterCount = mesh.clusterCount,
                     .emitter = c.emitter,
                     .glass = glassOf(scene, materials.material(scene, material), c, mesh),
                     .reflector = c.onCurved,
                     .why = c.whyCurved,
                     .roughness = c.roughness,
                     .reflectance = c.reflectance,
                     .area = mesh.area};
        if (c.onFlat == Reflector::flat) {
            for (std::uint32_t p = 0; p < mesh.flatPartCount; ++p) {
                const FlatPart& part = scene.flatParts[mesh.firstFlatPart + p];
                Surface mirror = rest;
                mirror.firstCluster = part.firstCluster;
                mirror.clusterCount = part.clusterCount;
                mirror.flatPart = mesh.firstFlatPart + p;
                mirror.reflector = Reflector::flat;
                mirror.why = c.whyFlat;
                mirror.area = part.area;
                surfaces.push_back(mirror);
                rest.firstCluster += part.clusterCount;
                rest.clusterCount -= part.clusterCount;
                rest.area = std::max(0.0, rest.area - part.area);
            }
        }
        if (rest.clusterCount > 0) surfaces.push_back(rest);
    }
    return surfaces;
}

std::string reflectorReason(const Scene& scene, const MaterialBindings& materials,
                            const Surface& surface) {
    const Material& m = materials.material(scene, surface.material);
    const float metallic = classOf(scene, m).metallic;
    const float roughness = surface.roughness;
    switch (surface.why) {
        case ReflectorReason::metal:
            return words("metal (metallic %.2g) and smooth (roughness %.2g)", metallic, roughness);
        case ReflectorReason::gloss:
            return words("smooth (roughness %.2g) and in one plane", roughness);
        case ReflectorReason::asked:
            return "its material says reflection: mirror";
        case ReflectorReason::probe:
            return "its material names the probe '" + m.probe + "'";
        case ReflectorReason::map:
            return "its material names the environment map '" + m.environmentMap + "'";
        case ReflectorReason::unlit:
            return "unlit";
        case ReflectorReason::refused:
            return "its material says reflection: none";
        case ReflectorReason::rough:
            return words("a metal, but rough (roughness %.2g, at most %.2g mirrors)", roughness,
                         kMirrorRoughness);
        case ReflectorReason::dull:
            return words(
                "no metal (metallic %.2g), and rough (roughness %.2g, at most %.2g is a "
                "glossy plane)",
                metallic, roughness, kGlossRoughness);
        case ReflectorReason::round:
            return words("smooth (roughness %.2g), but neither metal nor flat", roughness);
        case ReflectorReason::cutOut:
            return "no metal, and cut out by its picture";
        case ReflectorReason::noLobe:
            return "no metal, and its specular factor is 0";
    }
    return {};
}

std::string glassReason(const Scene& scene, const MaterialBindings& materials,
                        const Surface& surface) {
    const Material& m = materials.material(scene, surface.material);
    const float transmission = classOf(scene, m).transmission;
    if (surface.glass == Glass::solid) {
        return words("transmission %.2g and thickness %.3g: light passes a volume", transmission,
                     m.thickness);
    }
    if (surface.glass == Glass::none) return "lets no light through";
    return m.thickness > 0.0f
               ? words("transmission %.2g, and all in one plane: a pane %.3g thick", transmission,
                       m.thickness)
               : words("transmission %.2g without thickness: thin-walled", transmission);
}

std::string emitterReason(const Scene& scene, const MaterialBindings& materials,
                          const Surface& surface) {
    if (!surface.emitter) return "emits nothing";
    const glm::vec3 radiance = emittedRadiance(materials.material(scene, surface.material));
    return words("emits up to (%.3g, %.3g, %.3g)", radiance.x, radiance.y, radiance.z);
}

}  // namespace clerestory
