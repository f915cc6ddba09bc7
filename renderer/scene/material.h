// Materials and textures with the names of glTF 2.0 and KHR_materials_*. Colours and factors are
// linear. fields(Material&, ...) is the only list of a material's fields.
#pragma once

#include "scene/fields.h"

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include <array>
#include <concepts>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

namespace clerestory {

// A Gaussian blur of a captured or loaded environment map. The kernel covers 2 size + 1 texels in
// each direction. `size` and the standard deviation are in texels at the centre of a face. No blur
// if either is 0.
struct MapBlur {
    std::uint32_t size = 0;
    double stdev = 0.0;
    bool changes() const { return size > 0 && stdev > 0.0; }
    bool operator==(const MapBlur&) const = default;
};

inline constexpr std::uint32_t kLargestBlur = 64;

template <class B, class V>
requires std::same_as<std::remove_const_t<B>, MapBlur>
void fields(B& b, V&& visit) {
    visit("size", b.size, Range{0, kLargestBlur},
          "half-width of the kernel, texels: 2 size + 1 along each direction; 0: none");
    visit("stdev", b.stdev, Range{0, kLargestBlur}, "standard deviation, texels; 0: none");
}

using Index = std::uint32_t;
inline constexpr Index kNone = 0xffffffffu;

enum class ColorSpace : std::uint32_t { linear, srgb };
enum class Wrap : std::uint32_t { repeat, mirroredRepeat, clampToEdge };
enum class Filter : std::uint32_t { nearest, linear };

// The texels of one image, RGBA with 8 bits per channel; the first row is the top row (glTF: v =
// 0). `texels` contains all mip levels, level 0 first, down to 1x1; each level has half the size of
// the one before, rounded down, at least 1. Levels are averaged in linear light.
struct TextureImage {
    std::string name;
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::uint32_t levels = 0;
    ColorSpace colorSpace = ColorSpace::linear;
    bool hasAlpha = false;  // a texel has alpha below 255
    // R and A are x and y of unit normals, each from -1 to 1; see packNormals().
    bool packedNormal = false;
    glm::vec4 mean{1.0f};     // of all texels, linear light; alpha too
    float leastGreen = 1.0f;  // mean of the tenth of the texels with the least green; linear images
    // Root mean square of the slopes of a normal map; 0 for other images. See packNormals().
    float slope = 0.0f;
    std::vector<std::uint8_t> texels;
};

// An image and a sampler.
struct Texture {
    Index image = kNone;
    Wrap wrapU = Wrap::repeat;
    Wrap wrapV = Wrap::repeat;
    Filter magnify = Filter::linear;
    Filter minify = Filter::linear;
    bool useLevels = true;
};

// Where a material reads a texture: uv' = offset + R(rotation) * (scale * uv),
// KHR_texture_transform.
struct TextureSlot {
    Index texture = kNone;
    std::uint32_t texCoord = 0;  // 0 or 1: the vertex's texture coordinate set
    glm::vec2 offset{0.0f};
    glm::vec2 scale{1.0f};
    float rotation = 0.0f;  // radians, counter-clockwise as KHR_texture_transform has it

    bool operator==(const TextureSlot&) const = default;
    bool present() const { return texture != kNone; }
    bool transformed() const {
        return offset != glm::vec2(0.0f) || scale != glm::vec2(1.0f) || rotation != 0.0f;
    }
};

enum class AlphaMode : std::uint32_t { opaque, mask, blend };

// Whether a surface reflects the scene: automatic depends on metallic and roughness.
enum class Reflection : std::uint32_t { automatic, none, mirror };

struct Material {
    std::string name;

    glm::vec4 baseColor{1.0f};  // w is coverage
    TextureSlot baseColorTexture;
    float metallic = 1.0f;                 // 0..1
    float roughness = 1.0f;                // perceptual, 0..1; alpha = roughness^2
    TextureSlot metallicRoughnessTexture;  // G roughness, B metallic
    TextureSlot normalTexture;
    float normalScale = 1.0f;
    TextureSlot occlusionTexture;  // R; dims indirect light only
    float occlusionStrength = 1.0f;

    glm::vec3 emissive{0.0f};  // emitted radiance = emissive * emissiveStrength * texture
    float emissiveStrength = 1.0f;
    TextureSlot emissiveTexture;

    AlphaMode alphaMode = AlphaMode::opaque;
    float alphaCutoff = 0.5f;
    bool doubleSided = false;
    bool unlit = false;

    float ior = 1.5f;
    float specular = 1.0f;        // KHR_materials_specular: factor and colour of the dielectric F0
    TextureSlot specularTexture;  // A
    glm::vec3 specularColor{1.0f};
    TextureSlot specularColorTexture;
    float transmission = 0.0f;  // 0..1
    TextureSlot transmissionTexture;
    float thickness = 0.0f;  // metres in mesh space; 0 is a thin-walled surface
    TextureSlot thicknessTexture;
    glm::vec3 attenuationColor{1.0f};
    float attenuationDistance = 0.0f;  // metres; 0: no absorption
    float dispersion = 0.0f;           // 20 / Abbe number; 0: every colour has `ior`

    // Layers, from the uppermost one down.
    float clearcoat = 0.0f;        // share of the surface with a clear dielectric coat of index 1.5
    TextureSlot clearcoatTexture;  // R
    float clearcoatRoughness = 0.0f;
    TextureSlot clearcoatRoughnessTexture;  // G
    TextureSlot clearcoatNormalTexture;     // absent: the mesh's normal
    float clearcoatNormalScale = 1.0f;
    glm::vec3 sheenColor{0.0f};  // of fibres that scatter towards grazing angles
    TextureSlot sheenColorTexture;
    float sheenRoughness = 0.0f;
    TextureSlot sheenRoughnessTexture;  // A
    float iridescence = 0.0f;           // share of the surface with a thin film
    TextureSlot iridescenceTexture;     // R
    float iridescenceIor = 1.3f;
    float iridescenceThicknessMin = 100.0f, iridescenceThickness = 400.0f;  // nanometres
    // G: from iridescenceThicknessMin to iridescenceThickness
    TextureSlot iridescenceThicknessTexture;
    // Of the specular lobe: alpha along the direction is mix(alpha, 1, anisotropy^2).
    float anisotropy = 0.0f;
    float anisotropyRotation = 0.0f;         // radians, counter-clockwise from the tangent
    TextureSlot anisotropyTexture;           // RG: direction from -1 to 1; B: factor
    float diffuseTransmission = 0.0f;        // share of diffuse light that leaves on the other side
    TextureSlot diffuseTransmissionTexture;  // A
    glm::vec3 diffuseTransmissionColor{1.0f};
    TextureSlot diffuseTransmissionColorTexture;

    Reflection reflection = Reflection::automatic;
    std::string probe;           // name in Scene::probes; empty: an automatic probe
    std::string environmentMap;  // name of a loaded map to reflect instead
    glm::dquat environmentRotation{1.0, 0.0, 0.0, 0.0};  // world from that map; unit
    MapBlur mapBlur;                                     // of the reflected map, loaded or captured

    std::string extras;  // the file's "extras" as compact JSON; may be empty

    bool operator==(const Material&) const = default;
};

// ---- the field table ----------------------------------------------------------------------------

// A factor: each component is in [min, max]. A value that is not finite is replaced by `fallback`.
struct FactorRange {
    float min, max, fallback;
    float maxCoverage = max;  // of the fourth component
};
template <class E>
struct EnumRange {
    E last;  // the enumerators run from 0 to this one
};
struct Unchecked {};  // any value, or one that only the scene can check
struct SlotRange {};  // a TextureSlot; see its table

// Largest factor: products of a few stay finite in float.
inline constexpr float kMaxFactor = 1e6f;

template <class S, class V>
requires std::same_as<std::remove_const_t<S>, TextureSlot>
void fields(S& s, V&& visit) {
    constexpr FactorRange kTransform{-kMaxFactor, kMaxFactor, 0};
    visit("texture", s.texture, Unchecked{});
    visit("texCoord", s.texCoord, Unchecked{});
    visit("offset", s.offset, kTransform);
    visit("scale", s.scale, FactorRange{-kMaxFactor, kMaxFactor, 1});
    visit("rotation", s.rotation, kTransform);
}

// Calls visit(name, member, kind) for every field of a Material, const or not. Kinds are Text,
// Flag, Nested and Rotation of scene/fields.h and those above. Hash, blob, checks, cleaning and
// overrides walk this table: the order of the fields is part of contentHash().
template <class M, class V>
requires std::same_as<std::remove_const_t<M>, Material>
void fields(M& m, V&& visit) {
    constexpr std::size_t kMaxName = 200;  // bytes
    constexpr FactorRange kUnit{0, 1, 1}, kColor{0, kMaxFactor, 1};
    visit("name", m.name, Text{kMaxName});
    visit("extras", m.extras, Unchecked{});
    visit("baseColor", m.baseColor, FactorRange{0, kMaxFactor, 1, 1});
    visit("emissive", m.emissive, FactorRange{0, kMaxFactor, 0});
    visit("specularColor", m.specularColor, kColor);
    visit("attenuationColor", m.attenuationColor, kUnit);
    visit("metallic", m.metallic, FactorRange{0, 1, 0});
    visit("roughness", m.roughness, kUnit);
    visit("normalScale", m.normalScale, FactorRange{-kMaxFactor, kMaxFactor, 1});
    visit("occlusionStrength", m.occlusionStrength, kUnit);
    visit("emissiveStrength", m.emissiveStrength, kColor);
    visit("alphaCutoff", m.alphaCutoff, FactorRange{0, kMaxFactor, 0.5f});
    visit("ior", m.ior, FactorRange{1, 100, 1.5f});
    visit("specular", m.specular, kUnit);
    visit("transmission", m.transmission, FactorRange{0, 1, 0});
    visit("thickness", m.thickness, FactorRange{0, kMaxFactor, 0});
    visit("attenuationDistance", m.attenuationDistance, FactorRange{0, 1e30f, 0});
    visit("dispersion", m.dispersion, FactorRange{0, 20, 0});
    visit("clearcoat", m.clearcoat, FactorRange{0, 1, 0});
    visit("clearcoatRoughness", m.clearcoatRoughness, FactorRange{0, 1, 0});
    visit("clearcoatNormalScale", m.clearcoatNormalScale, FactorRange{-kMaxFactor, kMaxFactor, 1});
    visit("sheenColor", m.sheenColor, FactorRange{0, 1, 0});
    visit("sheenRoughness", m.sheenRoughness, FactorRange{0, 1, 0});
    visit("iridescence", m.iridescence, FactorRange{0, 1, 0});
    visit("iridescenceIor", m.iridescenceIor, FactorRange{1, 10, 1.3f});
    visit("iridescenceThicknessMin", m.iridescenceThicknessMin, FactorRange{0, 1e5f, 100});
    visit("iridescenceThickness", m.iridescenceThickness, FactorRange{0, 1e5f, 400});
    visit("anisotropy", m.anisotropy, FactorRange{0, 1, 0});
    visit("anisotropyRotation", m.anisotropyRotation, FactorRange{-kMaxFactor, kMaxFactor, 0});
    visit("diffuseTransmission", m.diffuseTransmission, FactorRange{0, 1, 0});
    visit("diffuseTransmissionColor", m.diffuseTransmissionColor, kUnit);
    visit("baseColorTexture", m.baseColorTexture, SlotRange{});
    visit("metallicRoughnessTexture", m.metallicRoughnessTexture, SlotRange{});
    visit("normalTexture", m.normalTexture, SlotRange{});
    visit("occlusionTexture", m.occlusionTexture, SlotRange{});
    visit("emissiveTexture", m.emissiveTexture, SlotRange{});
    visit("transmissionTexture", m.transmissionTexture, SlotRange{});
    visit("thicknessTexture", m.thicknessTexture, SlotRange{});
    visit("specularTexture", m.specularTexture, SlotRange{});
    visit("specularColorTexture", m.specularColorTexture, SlotRange{});
    visit("clearcoatTexture", m.clearcoatTexture, SlotRange{});
    visit("clearcoatRoughnessTexture", m.clearcoatRoughnessTexture, SlotRange{});
    visit("clearcoatNormalTexture", m.clearcoatNormalTexture, SlotRange{});
    visit("sheenColorTexture", m.sheenColorTexture, SlotRange{});
    visit("sheenRoughnessTexture", m.sheenRoughnessTexture, SlotRange{});
    visit("iridescenceTexture", m.iridescenceTexture, SlotRange{});
    visit("iridescenceThicknessTexture", m.iridescenceThicknessTexture, SlotRange{});
    visit("anisotropyTexture", m.anisotropyTexture, SlotRange{});
    visit("diffuseTransmissionTexture", m.diffuseTransmissionTexture, SlotRange{});
    visit("diffuseTransmissionColorTexture", m.diffuseTransmissionColorTexture, SlotRange{});
    visit("reflection", m.reflection, EnumRange<Reflection>{Reflection::mirror});
    visit("probe", m.probe, Text{kMaxName});
    visit("environmentMap", m.environmentMap, Text{kMaxName});
    visit("environmentRotation", m.environmentRotation, Rotation{});
    visit("mapBlur", m.mapBlur, Nested{});
    visit("alphaMode", m.alphaMode, EnumRange<AlphaMode>{AlphaMode::blend});
    visit("doubleSided", m.doubleSided, Flag{});
    visit("unlit", m.unlit, Flag{});
}

// All texture slots, in the order of the shaders.
template <class M>
requires std::same_as<std::remove_const_t<M>, Material>
auto textureSlots(M& m) {
    using Slot = std::conditional_t<std::is_const_v<M>, const TextureSlot, TextureSlot>;
    std::array<Slot*, 19> slots{};
    std::size_t count = 0;
    fields(m, [&](const char*, auto& member, const auto& kind) {
        if constexpr (std::same_as<std::decay_t<decltype(kind)>, SlotRange>) {
            slots.at(count++) = &member;
        }
    });
    return slots;
}

// Clear coat, sheen, iridescence, anisotropy, diffuse transmission or dispersion.
inline bool hasLayers(const Material& m) {
    return m.clearcoat > 0.0f || m.sheenColor != glm::vec3(0.0f) || m.iridescence > 0.0f ||
           m.anisotropy > 0.0f || m.diffuseTransmission > 0.0f ||
           (m.dispersion > 0.0f && m.transmission > 0.0f);
}

// The emitted radiance per channel, before the texture.
inline glm::vec3 emittedRadiance(const Material& m) {
    return m.emissive * m.emissiveStrength;
}

}  // namespace clerestory
