#include "scene/material_override.h"

#include "scene/spelling.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace clerestory {
namespace {

// For each instance the indices of the overrides that select it, in order.
std::vector<std::vector<std::uint32_t>> choicesOf(const Scene& scene,
                                                  const std::vector<Index>& materialOfInstance,
                                                  const std::vector<MaterialOverride>& overrides) {
    std::vector<std::vector<std::uint32_t>> choices(scene.instances.size());
    for (std::uint32_t o = 0; o < overrides.size(); ++o) {
        const MaterialOverride& from = overrides[o];
        if (!from.material && !from.node) continue;
        std::vector<bool> nodes;
        if (from.node) nodes = nodesAtOrBelow(scene, *from.node);
        for (std::size_t i = 0; i < choices.size(); ++i) {
            const bool byMaterial =
                !from.material || scene.materials[materialOfInstance[i]].name == *from.material;
            const bool byNode = !from.node || nodes[scene.instances[i].node];
            if (byMaterial && byNode) choices[i].push_back(o);
        }
    }
    return choices;
}

std::vector<Index> materialsOf(const Scene& scene, const std::optional<std::string>& name) {
    std::vector<Index> ofMesh(scene.meshes.size(), kNone);
    for (const Variant& variant : scene.variants) {
        if (variant.name != name) continue;
        for (const Variant::Choice& choice : variant.choices) ofMesh[choice.mesh] = choice.material;
    }
    std::vector<Index> materials;
    for (const Instance& instance : scene.instances) {
        const Index chosen = ofMesh[instance.mesh];
        materials.push_back(chosen == kNone ? instance.material : chosen);
    }
    return materials;
}

glm::vec4 slotMean(const Scene& scene, const TextureSlot& slot) {
    return slot.present() ? scene.images[scene.textures[slot.texture].image].mean : glm::vec4(1.0f);
}

// The value of an override's field as the material's field of the same name.
void assign(float& to, double from) {
    to = static_cast<float>(from);
}
void assign(glm::vec3& to, const glm::dvec3& from) {
    to = glm::vec3(from);
}
void assign(glm::vec4& to, const glm::dvec3& from) {  // coverage stays
    to = glm::vec4(glm::vec3(from), to.w);
}
void assign(glm::dquat& to, const Quaternion& q) {
    to = glm::normalize(glm::dquat(q[3], q[0], q[1], q[2]));
}
template <class T>
void assign(T& to, const T& from) {
    to = from;
}

}  // namespace

void apply(const Scene& scene, const MaterialOverride& from, Material& to) {
    if (from.baseColor && to.alphaMode == AlphaMode::blend) {
        to.baseColor.w *= slotMean(scene, to.baseColorTexture).w;  // the texture is removed below
    }
    if ((from.metallic || from.roughness) && to.metallicRoughnessTexture.present()) {
        const glm::vec4 mean = slotMean(scene, to.metallicRoughnessTexture);
        to.metallic *= mean.b;
        to.roughness *= mean.g;
        to.metallicRoughnessTexture = {};
    }
    // A masked material keeps its base colour texture, which has the mask.
    const bool keepsBaseColorTexture = to.alphaMode == AlphaMode::mask;
    fields(from, [&](std::string_view name, const auto& value, const auto&, const char*) {
        if (!value) return;
        const std::string textureName = std::string(name) + "Texture";
        fields(to, [&](std::string_view field, auto& member, const auto& kind) {
            if constexpr (requires { assign(member, *value); }) {
                if (field == name) assign(member, *value);
            }
            if constexpr (std::is_same_v<std::decay_t<decltype(kind)>, SlotRange>) {
                const bool keeps = name == "baseColor" && keepsBaseColorTexture;
                if (field == textureName && !keeps) member = {};
            }
        });
    });
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

MaterialBindings bindMaterials(const Scene& scene, const Pose& pose,
                               const std::vector<MaterialOverride>& overrides,
                               const std::optional<std::string>& variant) {
    MaterialBindings materials{.hidden = pose.hidden};
    if (overrides.empty() && !variant && pose.materials.empty()) return materials;
    materials.materialOfInstance = materialsOf(scene, variant);
    const auto choices = choicesOf(scene, materials.materialOfInstance, overrides);
    std::map<Index, const Material*> posed;
    for (const PosedMaterial& m : pose.materials) posed[m.material] = &m.value;
    std::map<std::pair<Index, std::vector<std::uint32_t>>, Index> made;
    bool changes = false;
    for (std::size_t i = 0; i < choices.size(); ++i) {
        const Index own = materials.materialOfInstance[i];
        const auto animated = posed.find(own);
        const bool modified = !choices[i].empty() || animated != posed.end();
        changes = changes || modified || own != scene.instances[i].material;
        if (!modified) continue;
        const auto next = static_cast<Index>(scene.materials.size() + materials.own.size());
        const auto [found, isNew] = made.try_emplace({own, choices[i]}, next);
        if (isNew) {
            Material material = animated == posed.end() ? scene.materials[own] : *animated->second;
            for (const std::uint32_t o : choices[i]) apply(scene, overrides[o], material);
            materials.own.push_back(std::move(material));
        }
        materials.materialOfInstance[i] = found->second;
    }
    if (!changes) materials.materialOfInstance.clear();
    return materials;
}

void applyOverrides(Scene& scene, const std::vector<MaterialOverride>& overrides) {
    MaterialBindings materials = bindMaterials(scene, Pose{}, overrides);
    for (std::size_t i = 0; i < materials.materialOfInstance.size(); ++i) {
        scene.instances[i].material = materials.materialOfInstance[i];
    }
    for (Material& material : materials.own) scene.materials.push_back(std::move(material));
}

}  // namespace clerestory
