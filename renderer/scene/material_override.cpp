// Choosing instances by name, and changing copies of their materials.
#include "scene/material_override.h"

#include "scene/spelling.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace clerestory {
namespace {

template <class Named>
std::vector<std::string_view> namesOf(const std::vector<Named>& things) {
    std::vector<std::string_view> names;
    for (const Named& thing : things) {
        if (!thing.name.empty()) names.push_back(thing.name);
    }
    std::sort(names.begin(), names.end());
    names.erase(std::unique(names.begin(), names.end()), names.end());
    return names;
}

// Whose name, or the name of a node above, is the wanted one. A parent stands before its children.
std::vector<bool> nodesAtOrBelow(const Scene& scene, const std::string& name) {
    std::vector<bool> chosen(scene.nodes.size());
    for (std::size_t i = 0; i < chosen.size(); ++i) {
        const Node& node = scene.nodes[i];
        chosen[i] = node.name == name || (node.parent != kNone && chosen[node.parent]);
    }
    return chosen;
}

// The overrides, by number and in order, that choose each instance.
std::vector<std::vector<std::uint32_t>> choicesOf(const Scene& scene,
                                                  const std::vector<MaterialOverride>& overrides) {
    std::vector<std::vector<std::uint32_t>> choices(scene.instances.size());
    for (std::uint32_t o = 0; o < overrides.size(); ++o) {
        const MaterialOverride& from = overrides[o];
        if (!from.material && !from.node) continue;
        std::vector<bool> nodes;
        if (from.node) nodes = nodesAtOrBelow(scene, *from.node);
        for (std::size_t i = 0; i < choices.size(); ++i) {
            const Instance& instance = scene.instances[i];
            const bool byMaterial =
                !from.material || scene.materials[instance.material].name == *from.material;
            if (byMaterial && (!from.node || nodes[instance.node])) choices[i].push_back(o);
        }
    }
    return choices;
}

glm::vec4 slotMean(const Scene& scene, const TextureSlot& slot) {
    return slot.present() ? scene.images[scene.textures[slot.texture].image].mean : glm::vec4(1.0f);
}

template <class From, class To>
bool set(const std::optional<From>& from, To& to) {
    if (from) to = To(*from);
    return from.has_value();
}

}  // namespace

void apply(const Scene& scene, const MaterialOverride& from, Material& to) {
    if (from.baseColor) {
        // Coverage that the picture held stays, by its mean where nothing else can hold it.
        const float coverage = to.baseColor.w * slotMean(scene, to.baseColorTexture).w;
        to.baseColor = glm::vec4(glm::vec3(*from.baseColor),
                                 to.alphaMode == AlphaMode::blend ? coverage : to.baseColor.w);
        if (to.alphaMode != AlphaMode::mask) to.baseColorTexture = {};
    }
    if ((from.metallic || from.roughness) && to.metallicRoughnessTexture.present()) {
        const glm::vec4 mean = slotMean(scene, to.metallicRoughnessTexture);
        to.metallic *= mean.b;
        to.roughness *= mean.g;
        to.metallicRoughnessTexture = {};
    }
    set(from.metallic, to.metallic);
    set(from.roughness, to.roughness);
    if (set(from.emissive, to.emissive)) to.emissiveTexture = {};
    set(from.emissiveStrength, to.emissiveStrength);
    if (set(from.transmission, to.transmission)) to.transmissionTexture = {};
    set(from.ior, to.ior);
    if (set(from.thickness, to.thickness)) to.thicknessTexture = {};
    set(from.attenuationColor, to.attenuationColor);
    set(from.attenuationDistance, to.attenuationDistance);
    set(from.reflection, to.reflection);
    set(from.probe, to.probe);
    set(from.environmentMap, to.environmentMap);
    set(from.mapBlur, to.mapBlur);
    if (from.environmentRotation) {
        const auto& q = *from.environmentRotation;
        to.environmentRotation = glm::normalize(glm::dquat(q[3], q[0], q[1], q[2]));
    }
}

std::vector<FieldError> problems(const Scene& scene, const std::vector<MaterialOverride>& overrides,
                                 const std::string& pointer) {
    std::vector<FieldError> errors;
    if (overrides.empty()) return errors;
    const auto materials = namesOf(scene.materials), nodes = namesOf(scene.nodes),
               probes = namesOf(scene.probes);
    for (std::size_t i = 0; i < overrides.size(); ++i) {
        const MaterialOverride& o = overrides[i];
        const std::string at = pointer + "/" + std::to_string(i);
        const auto requireName = [&](const char* what, const std::optional<std::string>& name,
                                     const std::vector<std::string_view>& known) {
            if (!name || std::binary_search(known.begin(), known.end(), std::string_view(*name))) {
                return;
            }
            errors.push_back({at + "/" + what,
                              "the scene has no " + std::string(what) + " of this name" +
                                  didYouMean(*name, known),
                              known.empty() ? "no " + std::string(what) + " has a name"
                                            : listedNearest(*name, known)});
        };
        if (!o.material && !o.node) {
            errors.push_back({at, "chooses nothing", "a material's name, a node's, or both"});
        }
        requireName("material", o.material, materials);
        requireName("node", o.node, nodes);
        if (o.probe != "") requireName("probe", o.probe, probes);
        if (o.environmentRotation && !isUnit(*o.environmentRotation)) {
            errors.push_back({at + "/environmentRotation", "is not a rotation", kRotationForms});
        }
    }
    return errors;
}

MaterialBindings bindMaterials(const Scene& scene, const std::vector<MaterialOverride>& overrides) {
    MaterialBindings materials;
    if (overrides.empty()) return materials;
    const auto choices = choicesOf(scene, overrides);
    std::map<std::pair<Index, std::vector<std::uint32_t>>, Index> made;
    for (std::size_t i = 0; i < choices.size(); ++i) {
        const Index own = scene.instances[i].material;
        materials.materialOfInstance.push_back(own);
        if (choices[i].empty()) continue;
        const auto next = static_cast<Index>(scene.materials.size() + materials.own.size());
        const auto [found, isNew] = made.try_emplace({own, choices[i]}, next);
        if (isNew) {
            Material material = scene.materials[own];
            for (const std::uint32_t o : choices[i]) apply(scene, overrides[o], material);
            materials.own.push_back(std::move(material));
        }
        materials.materialOfInstance.back() = found->second;
    }
    if (materials.own.empty()) materials.materialOfInstance.clear();
    return materials;
}

void dressForGood(Scene& scene, const std::vector<MaterialOverride>& overrides) {
    MaterialBindings materials = bindMaterials(scene, overrides);
    for (std::size_t i = 0; i < materials.materialOfInstance.size(); ++i) {
        scene.instances[i].material = materials.materialOfInstance[i];
    }
    for (Material& material : materials.own) scene.materials.push_back(std::move(material));
}

}  // namespace clerestory
