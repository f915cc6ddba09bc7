#include "scene/import/gltf/animation_pointers.h"

#include <charconv>
#include <span>

namespace clerestory {
namespace {

struct Row {
    std::string_view pointer, field;
};

constexpr Row kMaterialFactors[] = {
    {"pbrMetallicRoughness/baseColorFactor", "baseColor"},
    {"pbrMetallicRoughness/metallicFactor", "metallic"},
    {"pbrMetallicRoughness/roughnessFactor", "roughness"},
    {"normalTexture/scale", "normalScale"},
    {"occlusionTexture/strength", "occlusionStrength"},
    {"emissiveFactor", "emissive"},
    {"alphaCutoff", "alphaCutoff"},
    {"KHR_materials_emissive_strength/emissiveStrength", "emissiveStrength"},
    {"KHR_materials_ior/ior", "ior"},
    {"KHR_materials_specular/specularFactor", "specular"},
    {"KHR_materials_specular/specularColorFactor", "specularColor"},
    {"KHR_materials_transmission/transmissionFactor", "transmission"},
    {"KHR_materials_volume/thicknessFactor", "thickness"},
    {"KHR_materials_volume/attenuationColor", "attenuationColor"},
    {"KHR_materials_volume/attenuationDistance", "attenuationDistance"},
    {"KHR_materials_dispersion/dispersion", "dispersion"},
    {"KHR_materials_clearcoat/clearcoatFactor", "clearcoat"},
    {"KHR_materials_clearcoat/clearcoatRoughnessFactor", "clearcoatRoughness"},
    {"KHR_materials_clearcoat/clearcoatNormalTexture/scale", "clearcoatNormalScale"},
    {"KHR_materials_sheen/sheenColorFactor", "sheenColor"},
    {"KHR_materials_sheen/sheenRoughnessFactor", "sheenRoughness"},
    {"KHR_materials_iridescence/iridescenceFactor", "iridescence"},
    {"KHR_materials_iridescence/iridescenceIor", "iridescenceIor"},
    {"KHR_materials_iridescence/iridescenceThicknessMinimum", "iridescenceThicknessMin"},
    {"KHR_materials_iridescence/iridescenceThicknessMaximum", "iridescenceThickness"},
    {"KHR_materials_anisotropy/anisotropyStrength", "anisotropy"},
    {"KHR_materials_anisotropy/anisotropyRotation", "anisotropyRotation"},
    {"KHR_materials_diffuse_transmission/diffuseTransmissionFactor", "diffuseTransmission"},
    {"KHR_materials_diffuse_transmission/diffuseTransmissionColorFactor",
     "diffuseTransmissionColor"},
};

// Their slots have the names of their fields.
constexpr std::string_view kSlotFolders[] = {
    "pbrMetallicRoughness/",     "",
    "KHR_materials_specular/",   "KHR_materials_transmission/",
    "KHR_materials_volume/",     "KHR_materials_clearcoat/",
    "KHR_materials_sheen/",      "KHR_materials_iridescence/",
    "KHR_materials_anisotropy/", "KHR_materials_diffuse_transmission/",
};

constexpr Row kLightFactors[] = {
    {"color", "color"},
    {"intensity", "intensity"},
    {"range", "range"},
    {"spot/innerConeAngle", "innerConeAngle"},
    {"spot/outerConeAngle", "outerConeAngle"},
};

constexpr Row kCameraFactors[] = {
    {"perspective/yfov", "yfov"},    {"perspective/znear", "znear"},
    {"perspective/zfar", "zfar"},    {"orthographic/ymag", "yHalfHeight"},
    {"orthographic/znear", "znear"}, {"orthographic/zfar", "zfar"},
};

bool takePrefix(std::string_view& text, std::string_view prefix) {
    if (!text.starts_with(prefix)) return false;
    text.remove_prefix(prefix.size());
    return true;
}

// A number and the slash after it.
std::optional<Index> takeIndex(std::string_view& text) {
    Index index = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), index);
    if (error != std::errc() || end == text.data() + text.size() || *end != '/') return {};
    text.remove_prefix(static_cast<std::size_t>(end - text.data()) + 1);
    return index;
}

std::string fieldIn(std::span<const Row> rows, std::string_view pointer) {
    for (const Row& row : rows) {
        if (row.pointer == pointer) return std::string(row.field);
    }
    return {};
}

// "baseColorTexture/extensions/KHR_texture_transform/offset" as "baseColorTexture.offset".
std::string transformField(std::string_view pointer) {
    constexpr std::string_view kTransform = "/extensions/KHR_texture_transform/";
    const std::size_t at = pointer.find(kTransform);
    if (at == std::string_view::npos) return {};
    std::string_view slot = pointer.substr(0, at);
    for (const std::string_view folder : kSlotFolders) {
        if (folder.empty() ? slot.find('/') != std::string_view::npos : !takePrefix(slot, folder)) {
            continue;
        }
        std::string field(slot);
        field += '.';
        return field += pointer.substr(at + kTransform.size());
    }
    return {};
}

std::string materialField(std::string_view pointer) {
    takePrefix(pointer, "extensions/");
    const std::string factor = fieldIn(kMaterialFactors, pointer);
    return factor.empty() ? transformField(pointer) : factor;
}

std::optional<AnimatedProperty> nodeProperty(std::string_view name) {
    if (name == "translation") return AnimatedProperty::translation;
    if (name == "rotation") return AnimatedProperty::rotation;
    if (name == "scale") return AnimatedProperty::scale;
    if (name == "weights") return AnimatedProperty::weights;
    if (name == "extensions/KHR_node_visibility/visible") return AnimatedProperty::visible;
    return {};
}

}  // namespace

std::optional<PointerTarget> animatedBy(std::string_view pointer) {
    const auto target = [&](std::string_view list) -> std::optional<Index> {
        return takePrefix(pointer, list) ? takeIndex(pointer) : std::nullopt;
    };
    if (const auto node = target("/nodes/")) {
        const auto property = nodeProperty(pointer);
        if (!property) return {};
        return PointerTarget{*property, *node, {}};
    }
    const auto ofField = [](AnimatedProperty property, Index index,
                            std::string field) -> std::optional<PointerTarget> {
        if (componentsOf(property, field) == 0) return {};
        return PointerTarget{property, index, std::move(field)};
    };
    if (const auto material = target("/materials/")) {
        return ofField(AnimatedProperty::material, *material, materialField(pointer));
    }
    if (const auto camera = target("/cameras/")) {
        return ofField(AnimatedProperty::camera, *camera, fieldIn(kCameraFactors, pointer));
    }
    if (const auto light = target("/extensions/KHR_lights_punctual/lights/")) {
        return ofField(AnimatedProperty::light, *light, fieldIn(kLightFactors, pointer));
    }
    return {};
}

}  // namespace clerestory
