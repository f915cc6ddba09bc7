#include "plan/visibility/material_features.h"

#include "plan/graph/features.h"

#include <algorithm>
#include <vector>

namespace clerestory {
namespace {

// Most textured materials have default factors; their shader variant omits them.
bool hasDefaultNumbers(const Material& m) {
    const Material none;
    return m.metallic == none.metallic && m.roughness == none.roughness &&
           m.normalScale == none.normalScale && m.ior == none.ior && m.specular == none.specular &&
           m.specularColor == none.specularColor;
}

// Calls map(slot, bit) for the textures of the layers that the material has. Returns the layers.
template <class Map>
Features layerFeatures(const Material& m, const Map& map) {
    Features layers = 0;
    const auto textured = [&](const TextureSlot& slot, Features bit) { map(slot, ofLayers(bit)); };
    textured(m.specularTexture, LAYER_SPECULAR_MAP);
    textured(m.specularColorTexture, LAYER_SPECULAR_COLOR_MAP);
    if (m.clearcoat > 0.0f) {
        layers |= LAYER_CLEARCOAT;
        textured(m.clearcoatTexture, LAYER_CLEARCOAT_MAP);
        textured(m.clearcoatRoughnessTexture, LAYER_CLEARCOAT_ROUGHNESS_MAP);
        textured(m.clearcoatNormalTexture, LAYER_CLEARCOAT_NORMAL_MAP);
    }
    if (m.sheenColor != glm::vec3(0.0f)) {
        layers |= LAYER_SHEEN;
        textured(m.sheenColorTexture, LAYER_SHEEN_COLOR_MAP);
        textured(m.sheenRoughnessTexture, LAYER_SHEEN_ROUGHNESS_MAP);
    }
    if (m.iridescence > 0.0f) {
        layers |= LAYER_IRIDESCENCE;
        textured(m.iridescenceTexture, LAYER_IRIDESCENCE_MAP);
        textured(m.iridescenceThicknessTexture, LAYER_IRIDESCENCE_THICKNESS_MAP);
    }
    if (m.anisotropy > 0.0f) {
        layers |= LAYER_ANISOTROPY;
        textured(m.anisotropyTexture, LAYER_ANISOTROPY_MAP);
    }
    if (m.diffuseTransmission > 0.0f) {
        layers |= LAYER_DIFFUSE_TRANSMISSION;
        textured(m.diffuseTransmissionTexture, LAYER_DIFFUSE_TRANSMISSION_MAP);
        textured(m.diffuseTransmissionColorTexture, LAYER_DIFFUSE_TRANSMISSION_COLOR_MAP);
    }
    if (m.dispersion > 0.0f && m.transmission > 0.0f) layers |= LAYER_DISPERSION;
    return ofLayers(layers);
}

void addTexture(Features& features, const TextureSlot& slot, Features bit) {
    if (!slot.present()) return;
    features |= bit;
    if (slot.transformed()) features |= FEATURE_TEXTURE_TRANSFORM;
    if (slot.texCoord == 1) features |= FEATURE_SECOND_TEXCOORD;
}

// Texture features of glass of this material.
Features glassTextures(const Material& m) {
    Features features = 0;
    addTexture(features, m.metallicRoughnessTexture, FEATURE_METALLIC_ROUGHNESS_MAP);
    addTexture(features, m.transmissionTexture, FEATURE_TRANSMISSION_MAP);
    if (m.thickness > 0.0f) addTexture(features, m.thicknessTexture, FEATURE_THICKNESS_MAP);
    return features;
}

// Features that rays through the glass of the scene need.
Features featuresOfGlass(const Stage& stage) {
    Features all = 0;
    for (const Surface& surface : stage.surfaces) {
        if (surface.glass == Glass::none) continue;
        const Material& material = stage.material(surface);
        all |= FEATURE_GLASS;
        addTexture(all, material.transmissionTexture, FEATURE_TRANSMISSION_MAP);
        // Rays measure the thickness of solid glass.
        const bool thick = surface.glass == Glass::pane && material.thickness > 0.0f;
        if (thick) addTexture(all, material.thicknessTexture, FEATURE_THICKNESS_MAP);
    }
    return all;
}

}  // namespace

Features materialFeatures(const Scene& scene, const Material& m, const Mesh& mesh,
                          const Effects& effects) {
    Features f = 0;
    std::vector<const TextureSlot*> used;
    const auto map = [&](const TextureSlot& slot, Features bit) {
        if (slot.present()) {
            f |= bit;
            used.push_back(&slot);
        }
    };
    map(m.baseColorTexture, FEATURE_BASE_COLOR_MAP);
    if (m.unlit || !mesh.lit) {
        f |= FEATURE_UNLIT;
    } else {
        map(m.metallicRoughnessTexture, FEATURE_METALLIC_ROUGHNESS_MAP);
        if (m.normalScale != 0.0f) map(m.normalTexture, FEATURE_NORMAL_MAP);
        if ((f & FEATURE_NORMAL_MAP) &&
            scene.images[scene.textures[m.normalTexture.texture].image].packedNormal) {
            f |= FEATURE_PACKED_NORMAL;
        }
        if ((f & FEATURE_METALLIC_ROUGHNESS_MAP) && hasDefaultNumbers(m)) {
            f |= FEATURE_DEFAULT_NUMBERS;
        }
        if (m.occlusionStrength > 0.0f) map(m.occlusionTexture, FEATURE_OCCLUSION_MAP);
    }
    if (!m.unlit) {
        const glm::vec3 emitted = emittedRadiance(m);
        if (effects.emission && std::max({emitted.x, emitted.y, emitted.z}) > 0.0f) {
            f |= FEATURE_EMISSION;
            map(m.emissiveTexture, FEATURE_EMISSIVE_MAP);
        }
        if (effects.materialLayers) f |= layerFeatures(m, map);
    }
    for (const TextureSlot* slot : used) {
        if (slot->transformed()) f |= FEATURE_TEXTURE_TRANSFORM;
        if (slot->texCoord == 1) f |= FEATURE_SECOND_TEXCOORD;
    }
    if (mesh.hasColors) f |= FEATURE_VERTEX_COLOR;
    if (m.alphaMode == AlphaMode::mask) f |= FEATURE_MASK;
    if (m.alphaMode == AlphaMode::blend) f |= FEATURE_BLEND;
    if (m.doubleSided) f |= FEATURE_DOUBLE_SIDED;
    return f;
}

Features texturesOfGlass(const Stage& stage) {
    Features all = 0;
    for (const Surface& surface : stage.surfaces) {
        if (surface.glass != Glass::none) all |= glassTextures(stage.material(surface));
    }
    return all;
}

Features featuresOfAll(const Stage& stage) {
    Features all = stage.lights.empty() ? 0 : FEATURE_LIGHTS;
    for (Index i = 0; i < stage.scene.instances.size(); ++i) {
        const Mesh& mesh = stage.scene.meshes[stage.scene.instances[i].mesh];
        if (mesh.primitive != Primitive::triangles) continue;
        const Material& material =
            stage.materials.material(stage.scene, stage.materials.materialOf(stage.scene, i));
        all |= materialFeatures(stage.scene, material, mesh, stage.settings.effects);
    }
    all &= ~FEATURE_DEFAULT_NUMBERS;  // rays read the factors of each hit's material
    return stage.settings.effects.refraction ? all | featuresOfGlass(stage) : all;
}

}  // namespace clerestory
