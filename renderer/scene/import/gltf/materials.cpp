#include "scene/import/gltf/parts.h"

#include "scene/import/base/imported_scene.h"
#include "scene/import/base/sidecar.h"

#include <algorithm>
#include <cmath>

namespace clerestory {
namespace {

constexpr float kMaxIor = 100.0f;  // of the table of Material's fields

Wrap wrapOfGltf(std::uint64_t code) {
    switch (code) {  // the codes are OpenGL's
        case 33071:
            return Wrap::clampToEdge;
        case 33648:
            return Wrap::mirroredRepeat;
        default:
            return Wrap::repeat;
    }
}

Texture sampling(const Json& sampler) {
    constexpr std::uint64_t kNearest = 9728, kLinear = 9729, kNearestNearest = 9984,
                            kNearestLinear = 9986, kLinearLinear = 9987;
    Texture texture;
    texture.wrapU = wrapOfGltf(wholeNumber(sampler, "wrapS", 10497));
    texture.wrapV = wrapOfGltf(wholeNumber(sampler, "wrapT", 10497));
    const std::uint64_t magnify = wholeNumber(sampler, "magFilter", kLinear);
    const std::uint64_t minify = wholeNumber(sampler, "minFilter", kLinearLinear);
    texture.magnify = magnify == kNearest ? Filter::nearest : Filter::linear;
    const bool nearest =
        minify == kNearest || minify == kNearestNearest || minify == kNearestLinear;
    texture.minify = nearest ? Filter::nearest : Filter::linear;
    texture.useLevels = minify != kNearest && minify != kLinear;
    return texture;
}

glm::vec3 color(const Json& parent, const char* key, double fallback) {
    return glm::vec3(numbers<3>(parent, key, glm::dvec3(fallback)));
}

}  // namespace

void GltfMaterials::read() {
    for (const Json& json : array(document_.json(), "materials")) {
        if (!json.is_object()) {
            malformed("\"materials\" has an element that is not an object");
        }
        scene_.materials.push_back(material(json));
        cleanMaterial(scene_.materials.back(), scene_);
    }
    Material standard;
    standard.name = "glTF default";
    scene_.materials.push_back(standard);
}

Material GltfMaterials::material(const Json& json) {
    Material m;
    m.name = text(json, "name");
    readMetallicRoughness(object(json, "pbrMetallicRoughness"), m);
    m.normalTexture = slot(json, "normalTexture", ColorSpace::linear);
    m.normalScale = real(object(json, "normalTexture"), "scale", 1.0f);
    m.occlusionTexture = slot(json, "occlusionTexture", ColorSpace::linear);
    m.occlusionStrength = real(object(json, "occlusionTexture"), "strength", 1.0f);
    m.emissive = color(json, "emissiveFactor", 0.0);
    m.emissiveTexture = slot(json, "emissiveTexture", ColorSpace::srgb);

    const std::string mode = text(json, "alphaMode");
    m.alphaMode = mode == "MASK"    ? AlphaMode::mask
                  : mode == "BLEND" ? AlphaMode::blend
                                    : AlphaMode::opaque;
    m.alphaCutoff = real(json, "alphaCutoff", 0.5f);
    m.doubleSided = flag(json, "doubleSided", false);
    constexpr std::size_t kMaxExtras = 16384;  // bytes
    if (json.contains("extras")) {
        m.extras = json["extras"].dump(-1, ' ', false, Json::error_handler_t::replace);
        if (m.extras.size() > kMaxExtras) m.extras.clear();
        readMaterialExtras(json["extras"], m, scene_);
    }
    readExtensions(json, m);
    // glTF's default for metallic is 1, and metals do not transmit. A material with transmission
    // and without a metallic factor is treated as a dielectric.
    const Json& surface = object(json, "pbrMetallicRoughness");
    if (m.transmission > 0.0f && m.metallic == 1.0f && !surface.contains("metallicFactor") &&
        !m.metallicRoughnessTexture.present()) {
        m.metallic = 0.0f;
        scene_.warnings.push_back(
            {"transmissiveMetal", m.name,
             "it has transmission and the default metallic of 1; it is drawn as glass"});
    }
    return m;
}

void GltfMaterials::readMetallicRoughness(const Json& json, Material& m) {
    m.baseColor = glm::vec4(numbers<4>(json, "baseColorFactor", glm::dvec4(1.0)));
    m.baseColorTexture = slot(json, "baseColorTexture", ColorSpace::srgb);
    m.metallic = real(json, "metallicFactor", 1.0f);
    m.roughness = real(json, "roughnessFactor", 1.0f);
    m.metallicRoughnessTexture = slot(json, "metallicRoughnessTexture", ColorSpace::linear);
}

// With textures the factors are part of the converted images.
void GltfMaterials::readSpecularGlossinessTextures(const Json& json, Material& m) {
    ConvertedSource source;
    source.factors = {.diffuse = glm::vec3(m.baseColor),
                      .specular = color(json, "specularFactor", 1.0),
                      .glossiness = real(json, "glossinessFactor", 1.0f)};
    TextureSlot slots[2];
    Texture sampling[2];
    for (const int k : {0, 1}) {
        const char* key = k == 0 ? "diffuseTexture" : "specularGlossinessTexture";
        if (!json.contains(key)) continue;
        const Json& texture = document_.item("textures", indexAt(object(json, key), "index"));
        const Index image = imageOf(texture);
        if (image == kNone) {
            scene_.warnings.push_back({"missingTexture", m.name, "a texture has no image"});
            continue;
        }
        (k == 0 ? source.diffuse : source.specular) = imageSource(image);
        slots[k] = placement(object(json, key));
        sampling[k] = samplerOf(texture);
    }
    if (!source.diffuse) slots[0] = slots[1], sampling[0] = sampling[1];
    if (!source.specular) slots[1] = slots[0], sampling[1] = sampling[0];
    source.result = ConvertedTo::baseColor;
    m.baseColorTexture = slots[0];
    m.baseColorTexture.texture = textures_.texture(source, sampling[0]);
    source.result = ConvertedTo::metallicRoughness;
    m.metallicRoughnessTexture = slots[1];
    m.metallicRoughnessTexture.texture = textures_.texture(source, sampling[1]);
    m.baseColor = glm::vec4(1.0f, 1.0f, 1.0f, m.baseColor.w);
    m.metallic = m.roughness = 1.0f;
}

// Converts the factors: a bright specular colour over a dark diffuse one is a metal.
void GltfMaterials::readSpecularGlossiness(const Json& json, Material& m) {
    const glm::vec3 specular = color(json, "specularFactor", 1.0);
    const float brightest = std::max({specular.x, specular.y, specular.z});
    m.baseColor = glm::vec4(numbers<4>(json, "diffuseFactor", glm::dvec4(1.0)));
    if (json.contains("specularGlossinessTexture")) {
        readSpecularGlossinessTextures(json, m);
        return;
    }
    m.baseColorTexture = slot(json, "diffuseTexture", ColorSpace::srgb);
    m.metallicRoughnessTexture = {};
    m.roughness = 1.0f - real(json, "glossinessFactor", 1.0f);
    m.metallic = 0.0f;
    constexpr float kDielectricF0 = 0.04f;
    const float diffuse = std::max({m.baseColor.x, m.baseColor.y, m.baseColor.z});
    if (diffuse < kDielectricF0 && brightest > kDielectricF0) {
        m.metallic = 1.0f;
        m.baseColor = glm::vec4(specular, m.baseColor.w);
    } else if (brightest > 0.0f) {
        m.specularColor = specular / kDielectricF0;
    }
}

void GltfMaterials::readExtensions(const Json& json, Material& m) {
    if (const Json* e = extension(json, "KHR_materials_pbrSpecularGlossiness")) {
        readSpecularGlossiness(*e, m);
    }
    m.unlit = extension(json, "KHR_materials_unlit") != nullptr;
    if (const Json* e = extension(json, "KHR_materials_emissive_strength")) {
        m.emissiveStrength = real(*e, "emissiveStrength", 1.0f);
    }
    if (const Json* e = extension(json, "KHR_materials_ior")) {
        m.ior = real(*e, "ior", 1.5f);
        if (m.ior == 0.0f) m.ior = kMaxIor;  // the extension's value for a reflectance of 1
    }
    if (const Json* e = extension(json, "KHR_materials_specular")) {
        m.specular = real(*e, "specularFactor", 1.0f);
        m.specularTexture = slot(*e, "specularTexture", ColorSpace::linear);
        m.specularColor = color(*e, "specularColorFactor", 1.0);
        m.specularColorTexture = slot(*e, "specularColorTexture", ColorSpace::srgb);
    }
    if (const Json* e = extension(json, "KHR_materials_transmission")) {
        m.transmission = real(*e, "transmissionFactor", 0.0f);
        m.transmissionTexture = slot(*e, "transmissionTexture", ColorSpace::linear);
    }
    if (const Json* e = extension(json, "KHR_materials_volume")) {
        m.thickness = real(*e, "thicknessFactor", 0.0f);
        m.thicknessTexture = slot(*e, "thicknessTexture", ColorSpace::linear);
        m.attenuationColor = color(*e, "attenuationColor", 1.0);
        m.attenuationDistance = real(*e, "attenuationDistance", 0.0f);
    }
    readLayers(json, m);
}

void GltfMaterials::readLayers(const Json& json, Material& m) {
    if (const Json* e = extension(json, "KHR_materials_clearcoat")) {
        m.clearcoat = real(*e, "clearcoatFactor", 0.0f);
        m.clearcoatTexture = slot(*e, "clearcoatTexture", ColorSpace::linear);
        m.clearcoatRoughness = real(*e, "clearcoatRoughnessFactor", 0.0f);
        m.clearcoatRoughnessTexture = slot(*e, "clearcoatRoughnessTexture", ColorSpace::linear);
        m.clearcoatNormalTexture = slot(*e, "clearcoatNormalTexture", ColorSpace::linear);
        m.clearcoatNormalScale = real(object(*e, "clearcoatNormalTexture"), "scale", 1.0f);
    }
    if (const Json* e = extension(json, "KHR_materials_sheen")) {
        m.sheenColor = color(*e, "sheenColorFactor", 0.0);
        m.sheenColorTexture = slot(*e, "sheenColorTexture", ColorSpace::srgb);
        m.sheenRoughness = real(*e, "sheenRoughnessFactor", 0.0f);
        m.sheenRoughnessTexture = slot(*e, "sheenRoughnessTexture", ColorSpace::linear);
    }
    if (const Json* e = extension(json, "KHR_materials_iridescence")) {
        m.iridescence = real(*e, "iridescenceFactor", 0.0f);
        m.iridescenceTexture = slot(*e, "iridescenceTexture", ColorSpace::linear);
        m.iridescenceIor = real(*e, "iridescenceIor", 1.3f);
        m.iridescenceThicknessMin = real(*e, "iridescenceThicknessMinimum", 100.0f);
        m.iridescenceThickness = real(*e, "iridescenceThicknessMaximum", 400.0f);
        m.iridescenceThicknessTexture = slot(*e, "iridescenceThicknessTexture", ColorSpace::linear);
    }
    if (const Json* e = extension(json, "KHR_materials_anisotropy")) {
        m.anisotropy = real(*e, "anisotropyStrength", 0.0f);
        m.anisotropyRotation = real(*e, "anisotropyRotation", 0.0f);
        m.anisotropyTexture = slot(*e, "anisotropyTexture", ColorSpace::linear);
    }
    if (const Json* e = extension(json, "KHR_materials_diffuse_transmission")) {
        m.diffuseTransmission = real(*e, "diffuseTransmissionFactor", 0.0f);
        m.diffuseTransmissionTexture = slot(*e, "diffuseTransmissionTexture", ColorSpace::linear);
        m.diffuseTransmissionColor = color(*e, "diffuseTransmissionColorFactor", 1.0);
        m.diffuseTransmissionColorTexture =
            slot(*e, "diffuseTransmissionColorTexture", ColorSpace::srgb);
    }
    if (const Json* e = extension(json, "KHR_materials_dispersion")) {
        m.dispersion = real(*e, "dispersion", 0.0f);
    }
}

TextureSlot GltfMaterials::slot(const Json& parent, const char* key, ColorSpace colorSpace) {
    if (!parent.contains(key)) return {};
    const Json& json = object(parent, key);
    TextureSlot slot = placement(json);
    slot.texture = texture(indexAt(json, "index"), colorSpace);
    return slot;
}

// Without its texture.
TextureSlot GltfMaterials::placement(const Json& json) const {
    TextureSlot slot;
    slot.texCoord = static_cast<std::uint32_t>(wholeNumber(json, "texCoord", 0));
    if (const Json* transform = extension(json, "KHR_texture_transform")) {
        slot.offset = glm::vec2(numbers<2>(*transform, "offset", glm::dvec2(0.0)));
        slot.scale = glm::vec2(numbers<2>(*transform, "scale", glm::dvec2(1.0)));
        slot.rotation = real(*transform, "rotation", 0.0f);
        slot.texCoord =
            static_cast<std::uint32_t>(wholeNumber(*transform, "texCoord", slot.texCoord));
    }
    return slot;
}

Index GltfMaterials::texture(Index gltfTexture, ColorSpace colorSpace) {
    const Json& json = document_.item("textures", gltfTexture);
    const Index source = imageOf(json);
    if (source == kNone) {
        scene_.warnings.push_back({"missingTexture", text(json, "name"), "a texture has no image"});
        return kNone;
    }
    try {
        return textures_.texture(imageSource(source), colorSpace, samplerOf(json));
    } catch (const ImportError& error) {  // the scene is imported without the texture
        scene_.warnings.push_back(
            {"brokenTexture", "image " + std::to_string(source), error.what()});
        return kNone;
    }
}

Texture GltfMaterials::samplerOf(const Json& texture) const {
    const Index index = indexAt(texture, "sampler");
    return index == kNone ? Texture{} : sampling(document_.item("samplers", index));
}

// The image of an extension, else the fallback; kNone if there is none.
Index GltfMaterials::imageOf(const Json& texture) const {
    Index source = indexAt(texture, "source");
    for (const char* name : {"KHR_texture_basisu", "EXT_texture_webp", "EXT_texture_avif"}) {
        if (const Json* other = extension(texture, name)) source = indexAt(*other, "source");
    }
    return source;
}

ImageSource GltfMaterials::imageSource(Index gltfImage) {
    const Json& json = document_.item("images", gltfImage);
    ImageSource source;
    source.name = text(json, "name");
    const std::string number = "image " + std::to_string(gltfImage);
    if (const Index view = indexAt(json, "bufferView"); view != kNone) {
        source.key = "view " + std::to_string(view);
        source.embedded = document_.bufferView(view);
    } else if (const std::string uri = text(json, "uri"); isDataUri(uri)) {
        source.key = number;
        source.embedded = document_.dataUri(uri);
    } else {
        source.name = percentDecoded(uri);
        source.key = "file " + source.name;
        return source;
    }
    if (source.name.empty()) {
        source.name = number;
    }
    return source;
}

}  // namespace clerestory
