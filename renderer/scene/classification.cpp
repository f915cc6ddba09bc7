#include "scene/classification.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace clerestory {
namespace {

// A smaller factor does not change an 8-bit image.
constexpr float kNegligible = 1e-3f;

constexpr float kClearcoatF0 = 0.04f;

glm::vec4 meanOf(const Scene& scene, const TextureSlot& slot) {
    if (!slot.present()) return glm::vec4(1.0f);
    return scene.images[scene.textures[slot.texture].image].mean;
}

float leastGreenOf(const Scene& scene, const TextureSlot& slot) {
    if (!slot.present()) return 1.0f;
    return scene.images[scene.textures[slot.texture].image].leastGreen;
}

float average(const glm::vec3& c) {
    return (c.x + c.y + c.z) / 3.0f;
}

float reflectanceOf(const Scene& scene, const Material& m, float metallic) {
    const float root = (m.ior - 1.0f) / (m.ior + 1.0f);
    const glm::vec3 color = m.specularColor * glm::vec3(meanOf(scene, m.specularColorTexture));
    const float specular = m.specular * meanOf(scene, m.specularTexture).a;
    const float dielectric = specular * std::min(1.0f, root * root * average(color));
    const glm::vec3 base = glm::vec3(m.baseColor) * glm::vec3(meanOf(scene, m.baseColorTexture));
    // A film adds a reflecting face, mostly as bright as with its base.
    const float face = (m.iridescenceIor - 1.0f) / (m.iridescenceIor + 1.0f);
    const float film = 2.0f * m.iridescence * face * face;
    return std::min(1.0f, glm::mix(dielectric, std::min(1.0f, average(base)), metallic) + film);
}

float slopeOf(const Scene& scene, const TextureSlot& normals, float scale) {
    if (!normals.present()) return 0.0f;
    return scene.images[scene.textures[normals.texture].image].slope * std::abs(scale);
}

void setReflectors(const Material& m, MaterialClass& c) {
    const auto both = [&](Reflector flat, Reflector curved, ReflectorReason reason) {
        c.onFlat = flat;
        c.onCurved = curved;
        c.reasonFlat = c.reasonCurved = reason;
    };
    const bool metal = c.metallic >= kMirrorMetallic;
    const bool coated = c.clearcoat >= kMirrorClearcoat && c.clearcoatRoughness <= kGlossRoughness;
    const bool hasSpecular = metal || m.specular > 0.0f;
    if (m.unlit) return both(Reflector::none, Reflector::none, ReflectorReason::unlit);
    if (m.reflection == Reflection::none) {
        return both(Reflector::none, Reflector::none, ReflectorReason::disabled);
    }
    if (!hasSpecular && !coated) {
        return both(Reflector::none, Reflector::none, ReflectorReason::noSpecular);
    }
    if (!m.environmentMap.empty())
        return both(Reflector::curved, Reflector::curved, ReflectorReason::map);
    if (!m.probe.empty()) return both(Reflector::curved, Reflector::curved, ReflectorReason::probe);
    if (m.reflection == Reflection::mirror) {
        return both(Reflector::flat, Reflector::curved, ReflectorReason::requested);
    }
    const bool smooth = c.roughness <= (metal ? kMirrorRoughness : kGlossRoughness);
    if (coated && !smooth && m.alphaMode != AlphaMode::mask) {
        both(Reflector::flat, Reflector::none, ReflectorReason::clearcoat);
        c.reasonCurved = metal ? ReflectorReason::roughMetal : ReflectorReason::roughDielectric;
        return;
    }
    if (smooth && m.anisotropy > kMirrorAnisotropy) {
        return both(Reflector::none, Reflector::none, ReflectorReason::anisotropic);
    }
    if (metal) {
        if (smooth) return both(Reflector::flat, Reflector::curved, ReflectorReason::metal);
        return both(Reflector::none, Reflector::none, ReflectorReason::roughMetal);
    }
    if (!smooth) {
        both(Reflector::none, Reflector::none, ReflectorReason::roughDielectric);
        if (c.smoothest > kPatchRoughness || m.alphaMode == AlphaMode::mask) return;
        c.onFlat = Reflector::flat;
        c.reasonFlat = ReflectorReason::patches;
        return;
    }
    if (m.alphaMode == AlphaMode::mask) {
        return both(Reflector::none, Reflector::none, ReflectorReason::alphaMasked);
    }
    if (c.reflectance >= kBrightReflectance && !c.transmits) {
        return both(Reflector::flat, Reflector::curved, ReflectorReason::bright);
    }
    both(Reflector::flat, Reflector::none, ReflectorReason::gloss);
    c.reasonCurved = ReflectorReason::curvedDielectric;
}

// Whether all triangles of the mesh lie in one plane, facing either way.
bool isSheet(const Scene& scene, const Mesh& mesh) {
    if (mesh.flatPartCount == 0) return false;
    std::uint32_t clusters = 0;
    const FlatPart& first = scene.flatParts[mesh.firstFlatPart];
    // Each part is flat to 1e-4 of its diagonal, so two planes may differ by twice that.
    const double tolerance = 2e-4 * static_cast<double>(mesh.bounds.diagonal());
    for (std::uint32_t p = 0; p < mesh.flatPartCount; ++p) {
        const FlatPart& part = scene.flatParts[mesh.firstFlatPart + p];
        clusters += part.clusterCount;
        const double cosine = glm::dot(part.normal, first.normal);
        const double distance = std::abs(first.plane().distance(-part.offset * part.normal));
        if (std::abs(cosine) < 0.9998 || distance > tolerance) return false;
    }
    return clusters == mesh.clusterCount;
}

Glass glassOf(const Scene& scene, const Material& m, const MaterialClass& c, const Mesh& mesh) {
    if (!c.transmits) return Glass::none;
    return m.thickness > 0.0f && !isSheet(scene, mesh) ? Glass::solid : Glass::pane;
}

template <class... Numbers>
std::string formatted(const char* format, Numbers... numbers) {
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
    c.smoothest =
        std::min(c.roughness, m.roughness * leastGreenOf(scene, m.metallicRoughnessTexture));
    c.transmission = m.transmission * meanOf(scene, m.transmissionTexture).r;
    c.clearcoat = m.clearcoat * meanOf(scene, m.clearcoatTexture).r;
    c.clearcoatRoughness = m.clearcoatRoughness * meanOf(scene, m.clearcoatRoughnessTexture).g;
    c.reflectance = reflectanceOf(scene, m, c.metallic);
    c.slope = slopeOf(scene, m.normalTexture, m.normalScale);
    const glm::vec3 emitted = emittedRadiance(m);
    c.emitter = !m.unlit && std::max({emitted.x, emitted.y, emitted.z}) > 0.0f;
    // Alpha is coverage, never glass (erratum G6). Metals do not transmit.
    c.transmits = !m.unlit && c.transmission * (1.0f - c.metallic) > kNegligible;
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
        if (!materials.draws(i)) continue;
        const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
        const Index material = materials.materialOf(scene, i);
        const MaterialClass& c = classes[material];
        if (mesh.primitive != Primitive::triangles) {
            surfaces.push_back({.instance = i,
                                .material = material,
                                .firstCluster = mesh.firstCluster,
                                .clusterCount = mesh.clusterCount,
                                .emitter = c.emitter,
                                .reason = ReflectorReason::noSurface,
                                .roughness = c.roughness,
                                .reflectance = c.reflectance});
            continue;
        }
        Surface rest{.instance = i,
                     .material = material,
                     .firstCluster = mesh.firstCluster,
                     .clusterCount = mesh.clusterCount,
                     .emitter = c.emitter,
                     .glass = glassOf(scene, materials.material(scene, material), c, mesh),
                     .reflector = c.onCurved,
                     .reason = c.reasonCurved,
                     .roughness = c.roughness,
                     .smoothest = c.smoothest,
                     .reflectance = c.reflectance,
                     .slope = c.slope,
                     .area = mesh.area};
        rest.shell = rest.glass == Glass::pane && materials.material(scene, material).doubleSided &&
                     !isSheet(scene, mesh);
        if (c.onFlat == Reflector::flat) {
            for (std::uint32_t p = 0; p < mesh.flatPartCount; ++p) {
                const FlatPart& part = scene.flatParts[mesh.firstFlatPart + p];
                Surface mirror = rest;
                mirror.firstCluster = part.firstCluster;
                mirror.clusterCount = part.clusterCount;
                mirror.flatPart = mesh.firstFlatPart + p;
                mirror.shell = false;
                mirror.reflector = Reflector::flat;
                mirror.reason = c.reasonFlat;
                mirror.area = part.area;
                if (c.reasonFlat == ReflectorReason::clearcoat) {
                    const Material& m = materials.material(scene, material);
                    mirror.roughness = mirror.smoothest = c.clearcoatRoughness;
                    mirror.reflectance = kClearcoatF0 * c.clearcoat;
                    mirror.slope = slopeOf(scene, m.clearcoatNormalTexture, m.clearcoatNormalScale);
                }
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
    switch (surface.reason) {
        case ReflectorReason::metal:
            return formatted("metal (metallic %.2g) and smooth (roughness %.2g)", metallic,
                             roughness);
        case ReflectorReason::gloss:
            return formatted("smooth (roughness %.2g) and in one plane", roughness);
        case ReflectorReason::patches:
            return formatted("in one plane, with smooth patches (roughness %.2g; on average %.2g)",
                             surface.smoothest, roughness);
        case ReflectorReason::bright:
            return formatted("smooth (roughness %.2g) and bright (reflectance %.2g)", roughness,
                             surface.reflectance);
        case ReflectorReason::clearcoat:
            return formatted("a smooth clear coat (roughness %.2g) in one plane", roughness);
        case ReflectorReason::anisotropic:
            return formatted("smooth, but anisotropic (strength %.2g)", m.anisotropy);
        case ReflectorReason::requested:
            return "the material has reflection: mirror";
        case ReflectorReason::probe:
            return "the material names the probe '" + m.probe + "'";
        case ReflectorReason::map:
            return "the material names the environment map '" + m.environmentMap + "'";
        case ReflectorReason::unlit:
            return "unlit";
        case ReflectorReason::disabled:
            return "the material has reflection: none";
        case ReflectorReason::roughMetal:
            return formatted("metal, but too rough (roughness %.2g; a mirror has at most %.2g)",
                             roughness, kMirrorRoughness);
        case ReflectorReason::roughDielectric:
            return formatted(
                "dielectric (metallic %.2g) and too rough (roughness %.2g; a glossy plane has at "
                "most %.2g)",
                metallic, roughness, kGlossRoughness);
        case ReflectorReason::curvedDielectric:
            return formatted("smooth (roughness %.2g), but neither metal nor flat", roughness);
        case ReflectorReason::alphaMasked:
            return "dielectric with an alpha mask";
        case ReflectorReason::noSpecular:
            return "dielectric with specular factor 0";
        case ReflectorReason::noSurface:
            return "lines or points";
    }
    return {};
}

std::string glassReason(const Scene& scene, const MaterialBindings& materials,
                        const Surface& surface) {
    const Material& m = materials.material(scene, surface.material);
    const float transmission = classOf(scene, m).transmission;
    if (surface.glass == Glass::solid) {
        return formatted("transmission %.2g and thickness %.3g: light passes through a volume",
                         transmission, m.thickness);
    }
    if (surface.glass == Glass::none) return "does not transmit light";
    return m.thickness > 0.0f
               ? formatted("transmission %.2g and all in one plane: a pane of thickness %.3g",
                           transmission, m.thickness)
               : formatted("transmission %.2g without thickness: thin-walled", transmission);
}

std::string emitterReason(const Scene& scene, const MaterialBindings& materials,
                          const Surface& surface) {
    if (!surface.emitter) return "does not emit";
    const glm::vec3 radiance = emittedRadiance(materials.material(scene, surface.material));
    return formatted("emits up to (%.3g, %.3g, %.3g)", radiance.x, radiance.y, radiance.z);
}

}  // namespace clerestory
