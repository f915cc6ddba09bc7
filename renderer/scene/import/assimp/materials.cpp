#include "scene/import/assimp/parts.h"

#include "scene/import/base/imported_scene.h"

#include <assimp/material.h>
#include <assimp/scene.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace clerestory {
namespace {

float brightest(const glm::vec3& color) {
    return std::max({color.x, color.y, color.z});
}

std::optional<glm::vec3> color(const aiMaterial& from, const char* key, unsigned type,
                               unsigned index) {
    aiColor3D value;
    if (from.Get(key, type, index, value) != aiReturn_SUCCESS) {
        return std::nullopt;
    }
    return glm::vec3(value.r, value.g, value.b);
}

std::optional<float> real(const aiMaterial& from, const char* key, unsigned type, unsigned index) {
    float value = 0.0f;
    if (from.Get(key, type, index, value) != aiReturn_SUCCESS || !std::isfinite(value)) {
        return std::nullopt;
    }
    return value;
}

constexpr float kBlack = 0.04f, kBright = 0.2f;

// MTL illumination models with glass or refraction.
bool refracts(int illumination) {
    return illumination == 4 || illumination == 6 || illumination == 7 || illumination == 9;
}

int illumination(const aiMaterial& from) {  // MTL "illum"; 2 is the most common one
    int model = 2;
    from.Get("$mat.illum", 0, 0, model);
    return model;
}

Wrap wrapOfAssimp(int mode) {
    switch (mode) {
        case aiTextureMapMode_Clamp:
        case aiTextureMapMode_Decal:
            return Wrap::clampToEdge;
        case aiTextureMapMode_Mirror:
            return Wrap::mirroredRepeat;
        default:
            return Wrap::repeat;
    }
}

}  // namespace

float roughnessFromExponent(float exponent) {
    return std::pow(2.0f / (std::max(exponent, 0.0f) + 2.0f), 0.25f);
}

void AssimpMaterials::read() {
    for (unsigned i = 0; i < file_.mNumMaterials; ++i) {
        scene_.materials.push_back(material(*file_.mMaterials[i]));
        cleanMaterial(scene_.materials.back(), scene_);
    }
}

Material AssimpMaterials::material(const aiMaterial& from) {
    Material m;
    aiString name;
    if (from.Get(AI_MATKEY_NAME, name) == aiReturn_SUCCESS) {
        m.name = name.C_Str();
    }
    // These formats do not define the winding: both sides are drawn unless the file says otherwise.
    int twoSided = 1;
    from.Get(AI_MATKEY_TWOSIDED, twoSided);
    m.doubleSided = twoSided != 0;
    readSurface(from, m);
    readReflection(from, m);
    readTransparency(from, m);
    readTextures(from, m);
    return m;
}

void AssimpMaterials::readSurface(const aiMaterial& from, Material& m) {
    const glm::vec3 diffuse = color(from, AI_MATKEY_COLOR_DIFFUSE).value_or(glm::vec3(0.8f));
    const glm::vec3 specular = color(from, AI_MATKEY_COLOR_SPECULAR).value_or(glm::vec3(0.0f));
    m.baseColor = glm::vec4(color(from, AI_MATKEY_BASE_COLOR).value_or(diffuse), 1.0f);
    m.metallic = real(from, AI_MATKEY_METALLIC_FACTOR).value_or(0.0f);
    const auto exponent = real(from, AI_MATKEY_SHININESS);
    const int model = illumination(from);
    const bool hasHighlight = brightest(specular) > 0.0f;
    m.roughness = real(from, AI_MATKEY_ROUGHNESS_FACTOR)
                      .value_or(hasHighlight && exponent ? roughnessFromExponent(*exponent) : 1.0f);
    // MTL 3 and 5 have traced reflections, which are sharp for any exponent Ns. Without a diffuse
    // colour the surface is a metal mirror.
    if (isObj_ && (model == 3 || model == 5) && brightest(diffuse) < kBlack &&
        brightest(specular) > kBright) {
        m.metallic = 1.0f;
        m.roughness = 0.0f;
        m.baseColor = glm::vec4(specular, 1.0f);
    }
    // Emission is independent of the diffuse colour (erratum E1).
    m.emissive = color(from, AI_MATKEY_COLOR_EMISSIVE).value_or(glm::vec3(0.0f));
    m.emissiveStrength = real(from, AI_MATKEY_EMISSIVE_INTENSITY).value_or(1.0f);
}

// Sets reflection: mirror independently of highlights: in MTL for models with traced or mapped
// reflections; in other formats if at least half of the light is reflected and there are highlights
// (exporters write a reflectivity of 1 with a black reflective colour, or for matte surfaces).
void AssimpMaterials::readReflection(const aiMaterial& from, Material& m) {
    const glm::vec3 specular = color(from, AI_MATKEY_COLOR_SPECULAR).value_or(glm::vec3(0.0f));
    if (isObj_) {
        const int model = illumination(from);
        const bool traced = model == 3 || model == 5 || model == 8;
        if (!traced || brightest(specular) <= kBright || m.metallic > 0.0f) return;
        m.reflection = Reflection::mirror;
        if (real(from, AI_MATKEY_SHININESS).value_or(0.0f) <= 0.0f) m.roughness = 0.0f;
        return;
    }
    constexpr float kReflective = 0.5f;
    int shading = 0;
    from.Get(AI_MATKEY_SHADING_MODEL, shading);
    const bool hasHighlight = shading == aiShadingMode_Phong || shading == aiShadingMode_Blinn;
    const float strength =
        real(from, AI_MATKEY_REFLECTIVITY).value_or(0.0f) *
        brightest(color(from, AI_MATKEY_COLOR_REFLECTIVE).value_or(glm::vec3(0.0f)));
    if (hasHighlight && brightest(specular) > 0.0f && strength >= kReflective) {
        m.reflection = Reflection::mirror;
    }
}

void AssimpMaterials::setGlassThickness() {
    if (!isObj_) return;
    std::vector<const Mesh*> largest(scene_.materials.size(), nullptr);
    for (const Mesh& mesh : scene_.meshes) {
        if (mesh.material >= largest.size()) continue;
        const Mesh*& candidate = largest[mesh.material];
        if (!candidate || mesh.bounds.diagonal() > candidate->bounds.diagonal()) candidate = &mesh;
    }
    for (std::size_t i = 0; i < largest.size() && i < file_.mNumMaterials; ++i) {
        Material& m = scene_.materials[i];
        const float ior = real(*file_.mMaterials[i], AI_MATKEY_REFRACTI).value_or(1.0f);
        if (!largest[i] || !(m.transmission > 0.0f) || !(ior > 1.0f)) continue;
        const glm::vec3 extent = largest[i]->bounds.extent();
        m.thickness = std::min({extent.x, extent.y, extent.z});
    }
}

void AssimpMaterials::readTransparency(const aiMaterial& from, Material& m) {
    const float opacity = std::clamp(real(from, AI_MATKEY_OPACITY).value_or(1.0f), 0.0f, 1.0f);
    const float ior = real(from, AI_MATKEY_REFRACTI).value_or(1.0f);
    if (ior > 1.0f) {  // 1 is the default of exporters
        m.ior = ior;
    }
    m.transmission = real(from, AI_MATKEY_TRANSMISSION_FACTOR).value_or(0.0f);
    // Some exporters write a glass model without opacity; others write it for every material. It is
    // glass if the material has no diffuse colour.
    const bool black = !(brightest(glm::vec3(m.baseColor)) >= kBlack) &&
                       from.GetTextureCount(aiTextureType_DIFFUSE) == 0;
    const bool glass = isObj_ && refracts(illumination(from));
    if (opacity >= 1.0f && !(glass && black)) {
        return;
    }
    if (!isObj_ || !(glass || ior > 1.0f)) {
        if (opacity == 0.0f) {
            // Several COLLADA and FBX exporters write 0 instead of 1.
            scene_.warnings.push_back(
                {"invisibleMaterial", m.name, "the opacity is 0; the material is drawn as opaque"});
            return;
        }
        m.alphaMode = AlphaMode::blend;
        m.baseColor.w = opacity;
        return;
    }
    m.transmission = opacity < 1.0f ? 1.0f - opacity : 1.0f;
    m.roughness = 0.0f;  // traced refraction is sharp
    if (black) {         // the tint of glass is Tf
        const glm::vec3 filter = color(from, AI_MATKEY_COLOR_TRANSPARENT).value_or(glm::vec3(1.0f));
        m.baseColor = glm::vec4(brightest(filter) > 0.0f ? filter : glm::vec3(1.0f), 1.0f);
    }
}

void AssimpMaterials::readTextures(const aiMaterial& from, Material& m) {
    const auto has = [&](aiTextureType kind) { return from.GetTextureCount(kind) > 0; };
    const aiTextureType colorKind =
        has(aiTextureType_BASE_COLOR) ? aiTextureType_BASE_COLOR : aiTextureType_DIFFUSE;
    // An image's alpha is coverage only if the material has an opacity texture (erratum G6): the
    // same image, or another one whose brightness is the coverage.
    aiString opacityPath, colorPath;
    from.GetTexture(aiTextureType_OPACITY, 0, &opacityPath);
    from.GetTexture(colorKind, 0, &colorPath);
    if (has(aiTextureType_OPACITY) && has(colorKind) && m.alphaMode == AlphaMode::opaque) {
        m.alphaMode = AlphaMode::mask;
    }
    const bool separateCoverage = has(aiTextureType_OPACITY) && !(opacityPath == colorPath);
    m.baseColorTexture = slot(from, colorKind, ColorSpace::srgb,
                              separateCoverage ? opacityPath.C_Str() : std::string());
    if (m.baseColorTexture.present() && !(brightest(glm::vec3(m.baseColor)) > 0.0f)) {
        m.baseColor = glm::vec4(1.0f, 1.0f, 1.0f, m.baseColor.w);  // the texture has the colour
    }
    m.normalTexture =
        slot(from,
             has(aiTextureType_NORMAL_CAMERA) ? aiTextureType_NORMAL_CAMERA : aiTextureType_NORMALS,
             ColorSpace::linear);
    m.emissiveTexture = slot(from, aiTextureType_EMISSIVE, ColorSpace::srgb);
    if (m.emissiveTexture.present() && !(brightest(m.emissive) > 0.0f)) {
        m.emissive = glm::vec3(1.0f);
    }
    m.occlusionTexture = slot(from, aiTextureType_AMBIENT_OCCLUSION, ColorSpace::linear);

    if (has(aiTextureType_HEIGHT)) {
        scene_.warnings.push_back({"unsupportedTexture", m.name, "a bump texture is not used"});
    }
    if (has(aiTextureType_METALNESS) || has(aiTextureType_DIFFUSE_ROUGHNESS)) {
        scene_.warnings.push_back({"unsupportedTexture", m.name,
                                   "separate metallic and roughness textures are not used"});
    }
}

TextureSlot AssimpMaterials::slot(const aiMaterial& from, int kind, ColorSpace colorSpace,
                                  const std::string& coverage) {
    TextureSlot slot;
    const auto type = static_cast<aiTextureType>(kind);
    aiString path;
    if (from.GetTexture(type, 0, &path) != aiReturn_SUCCESS || path.length == 0) {
        return slot;
    }
    Texture sampler;
    int modeU = aiTextureMapMode_Wrap;
    int modeV = aiTextureMapMode_Wrap;
    from.Get(AI_MATKEY_MAPPINGMODE_U(type, 0), modeU);
    from.Get(AI_MATKEY_MAPPINGMODE_V(type, 0), modeV);
    sampler.wrapU = wrapOfAssimp(modeU);
    sampler.wrapV = wrapOfAssimp(modeV);
    ImageSource source = imageSource(path.C_Str());
    if (!coverage.empty()) {
        source.coverage = imageSource(coverage).name;
        source.key += " covered by " + source.coverage;
    }
    slot.texture = textures_.texture(source, colorSpace, sampler);
    int channel = 0;
    if (from.Get(AI_MATKEY_UVWSRC(type, 0), channel) == aiReturn_SUCCESS) {
        slot.texCoord = channel == 1 ? 1 : 0;
    }
    aiUVTransform transform;
    if (from.Get(AI_MATKEY_UVTRANSFORM(type, 0), transform) == aiReturn_SUCCESS) {
        // v increases upwards in these formats, and aiProcess_FlipUVs has already negated the
        // translation: v' = 1 - (scale * (1 - v) + offset).
        slot.scale = {transform.mScaling.x, transform.mScaling.y};
        slot.offset = {transform.mTranslation.x,
                       1.0f - transform.mScaling.y + transform.mTranslation.y};
    }
    return slot;
}

// Authoring programs write absolute paths; then the file with that name in the scene's folder is
// used.
ImageSource AssimpMaterials::imageSource(std::string path) {
    ImageSource source;
    if (const aiTexture* embedded = file_.GetEmbeddedTexture(path.c_str())) {
        source.name = path;
        source.key = "embedded " + path;
        if (embedded->mHeight == 0) {  // compressed; mWidth is the size in bytes
            source.embedded = {reinterpret_cast<const unsigned char*>(embedded->pcData),
                               embedded->mWidth};
        }
        return source;
    }
    std::replace(path.begin(), path.end(), '\\', '/');
    if (!folder_.has(path)) {
        const std::string last = path.substr(path.find_last_of('/') + 1);
        path = folder_.has(last) ? last : path;
    }
    source.name = path;
    source.key = "file " + path;
    return source;
}

}  // namespace clerestory
