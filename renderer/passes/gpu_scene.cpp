#include "passes/gpu_scene.h"

#include "gl/context.h"
#include "passes/draw_parts.h"
#include "passes/draw_stream.h"
#include "plan/graph/features.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

namespace clerestory {
namespace {

constexpr std::array<Features, MATERIAL_SLOTS> kSlotFeatures = {
    FEATURE_BASE_COLOR_MAP,
    FEATURE_METALLIC_ROUGHNESS_MAP,
    FEATURE_NORMAL_MAP,
    FEATURE_OCCLUSION_MAP,
    FEATURE_EMISSIVE_MAP,
    FEATURE_TRANSMISSION_MAP,
    FEATURE_THICKNESS_MAP,
    ofLayers(LAYER_SPECULAR_MAP),
    ofLayers(LAYER_SPECULAR_COLOR_MAP),
    ofLayers(LAYER_CLEARCOAT_MAP),
    ofLayers(LAYER_CLEARCOAT_ROUGHNESS_MAP),
    ofLayers(LAYER_CLEARCOAT_NORMAL_MAP),
    ofLayers(LAYER_SHEEN_COLOR_MAP),
    ofLayers(LAYER_SHEEN_ROUGHNESS_MAP),
    ofLayers(LAYER_IRIDESCENCE_MAP),
    ofLayers(LAYER_IRIDESCENCE_THICKNESS_MAP),
    ofLayers(LAYER_ANISOTROPY_MAP),
    ofLayers(LAYER_DIFFUSE_TRANSMISSION_MAP),
    ofLayers(LAYER_DIFFUSE_TRANSMISSION_COLOR_MAP)};
constexpr std::array<unsigned, BASE_SLOTS> kBaseUnits = {
    UNIT_BASE_COLOR, UNIT_METALLIC_ROUGHNESS, UNIT_NORMAL,   UNIT_OCCLUSION,
    UNIT_EMISSIVE,   UNIT_TRANSMISSION,       UNIT_THICKNESS};

unsigned unitOf(std::size_t slot) {
    return slot < BASE_SLOTS ? kBaseUnits[slot]
                             : UNIT_SPECULAR + static_cast<unsigned>(slot - BASE_SLOTS);
}

gl::Texture uploaded(const TextureImage& image) {
    gl::Texture texture({.format = image.colorSpace == ColorSpace::srgb ? gl::TextureFormat::srgba8
                                                                        : gl::TextureFormat::rgba8,
                         .width = image.width,
                         .height = image.height,
                         .levels = image.levels});
    std::size_t offset = 0;
    for (std::uint32_t level = 0; level < image.levels; ++level) {
        const std::size_t size = std::size_t{4} * std::max(1u, image.width >> level) *
                                 std::max(1u, image.height >> level);
        texture.upload(level, 0, std::as_bytes(std::span(image.texels).subspan(offset, size)));
        offset += size;
    }
    return texture;
}

// White, and to a driver that compiles shaders for kinds of textures of the same kind as `image`:
// its format, whether edges are powers of two, and whether there are smaller levels.
gl::Texture whiteTextureLike(const TextureImage& image) {
    const bool powers = std::has_single_bit(image.width) && std::has_single_bit(image.height);
    TextureImage white{.width = powers ? 2u : 3u, .colorSpace = image.colorSpace};
    white.height = white.width;
    white.levels = image.levels > 1 ? 2 : 1;
    white.texels.assign(4 * (9 + 1), 255);
    return uploaded(white);
}

gl::Buffer vertexBuffer(const Scene& scene) {
    const auto content = std::as_bytes(std::span(scene.vertices));
    if (scene.deformations.empty()) return gl::Buffer::sharing(content);
    gl::Buffer changing;
    changing.assign(content);
    return changing;
}

gl::VertexArray vertexArrayOf(const gl::Buffer& vertices, const gl::Buffer& indices,
                              const gl::Buffer& drawRecords) {
    std::vector<gl::Attribute> attributes;
    const auto vertex = [&](std::uint32_t slot, std::uint32_t components, std::size_t offset) {
        attributes.push_back({.slot = slot,
                              .components = components,
                              .offset = static_cast<std::uint32_t>(offset),
                              .stride = sizeof(Vertex),
                              .buffer = &vertices});
    };
    vertex(ATTRIBUTE_POSITION, 3, offsetof(Vertex, position));
    vertex(ATTRIBUTE_NORMAL, 3, offsetof(Vertex, normal));
    vertex(ATTRIBUTE_TANGENT, 4, offsetof(Vertex, tangent));
    vertex(ATTRIBUTE_TEXCOORD0, 2, offsetof(Vertex, texCoord0));
    vertex(ATTRIBUTE_TEXCOORD1, 2, offsetof(Vertex, texCoord1));
    vertex(ATTRIBUTE_COLOR, 4, offsetof(Vertex, color));
    for (std::uint32_t row = 0; row < 6; ++row) {
        attributes.push_back({.slot = ATTRIBUTE_EYE_FROM_MODEL + row,
                              .offset = row * 16,
                              .stride = sizeof(DrawRecord),
                              .perInstance = true,
                              .buffer = &drawRecords});
    }
    return {attributes, &indices};
}

gl::Wrapping wrappingOf(Wrap wrap) {
    switch (wrap) {
        case Wrap::repeat:
            return gl::Wrapping::repeat;
        case Wrap::mirroredRepeat:
            return gl::Wrapping::mirroredRepeat;
        case Wrap::clampToEdge:
            return gl::Wrapping::clampToEdge;
    }
    return gl::Wrapping::repeat;
}

// Without anisotropy, data textures use the nearest level: blending two levels costs twice the
// fetches on a processor (Sponza at 1280x720: 6 of 113 ms) and is visible in colour textures only.
gl::SamplerDescription samplerOf(const Texture& t, bool holdsColor, const TextureFilter& filter) {
    const bool smooth = t.minify == Filter::linear;
    const bool blended = smooth && (holdsColor || filter.anisotropy > 1);
    return {.wrapU = wrappingOf(t.wrapU),
            .wrapV = wrappingOf(t.wrapV),
            .magnifyLinear = t.magnify == Filter::linear,
            .minifyLinear = smooth,
            .levels = !t.useLevels ? gl::LevelFilter::none
                      : blended    ? gl::LevelFilter::linear
                                   : gl::LevelFilter::nearest,
            .anisotropy = smooth && t.useLevels ? filter.anisotropy : 1,
            .levelsBelow = smooth && holdsColor && t.useLevels ? filter.colorLevelsBelow : 0};
}

}  // namespace

const gl::Sampler& SamplerCache::sampler(const gl::SamplerDescription& description) {
    return samplers_.try_emplace(description, description).first->second;
}

GpuScene::GpuScene(std::shared_ptr<const Scene> scene, const gl::Buffer& drawRecords,
                   std::span<const GpuScene* const> texturesOf,
                   const std::function<void(std::size_t)>& afterImage)
    : scene_(std::move(scene)),
      vertices_(vertexBuffer(*scene_)),
      indices_(gl::Buffer::sharing(std::as_bytes(std::span(scene_->indices)))),
      vertexArray_(vertexArrayOf(vertices_, indices_, drawRecords)) {
    materials_.assign(scene_->materials);
    for (const GpuScene* source : texturesOf) {
        images_.insert(images_.end(), source->images_.begin(), source->images_.end());
    }
    for (std::size_t i = images_.size(); i < scene_->images.size(); ++i) {
        images_.push_back(std::make_shared<const gl::Texture>(uploaded(scene_->images[i])));
        if (afterImage) afterImage(i);
    }
    texels_ = texturesOf.size() == 1 ? texturesOf.front()->texels_
                                     : std::make_shared<std::weak_ptr<const TracedTexels>>();
    for (const Material& material : scene_->materials) {
        const auto slots = textureSlots(material);
        for (std::size_t slot = 0; slot < MATERIAL_SLOTS; ++slot) {
            if (!slots[slot]->present() || whites_.contains(slot)) continue;
            const Texture& texture = scene_->textures[slots[slot]->texture];
            whites_.emplace(slot, White{whiteTextureLike(scene_->images[texture.image]), texture});
        }
    }
}

std::shared_ptr<const TracedTexels> GpuScene::texels() const {
    auto texels = texels_->lock();
    if (!texels) {
        texels = std::make_shared<const TracedTexels>(tracedTexels(*scene_, images_));
        *texels_ = texels;
    }
    return texels;
}

std::uint64_t GpuScene::follow(const Pose& pose) {
    std::uint64_t moved = 0;
    deformed_.resize(pose.deformed.size(), 0);
    for (std::size_t i = 0; i < pose.deformed.size(); ++i) {
        const DeformedMesh& mesh = *pose.deformed[i];
        if (deformed_[i] == mesh.hash) continue;
        vertices_.replace(mesh.firstVertex * sizeof(Vertex),
                          std::as_bytes(std::span(mesh.vertices)));
        deformed_[i] = mesh.hash;
        ++moved;
    }
    return moved;
}

void GpuScene::bindMaterial(Index material, const FrameMaterials& own, Features features,
                            const TextureFilter& filter, SamplerCache& samplers) const {
    const std::size_t count = scene_->materials.size();
    const bool ofScene = material < count;
    (ofScene ? materials_ : own.blocks)
        .bind(ofScene ? material : material - count, features >> 32 != 0);
    const auto slots =
        textureSlots(ofScene ? scene_->materials[material] : own.materials[material - count]);
    for (std::size_t slot = 0; slot < MATERIAL_SLOTS; ++slot) {
        if (!(features & kSlotFeatures[slot])) continue;
        const unsigned unit = unitOf(slot);
        const bool present = slots[slot]->present();
        const Texture& texture =
            present ? scene_->textures[slots[slot]->texture] : whites_.at(slot).sampledAs;
        (present ? *images_[texture.image] : whites_.at(slot).texture).bind(unit);
        const bool holdsColor = scene_->images[texture.image].colorSpace == ColorSpace::srgb;
        samplers.sampler(samplerOf(texture, holdsColor, filter)).bind(unit);
    }
}

std::span<const float> GpuScene::clusterAreas() const {
    if (clusterAreas_.size() != scene_->clusters.size()) {
        clusterAreas_ = clerestory::clusterAreas(*scene_);
    }
    return clusterAreas_;
}

}  // namespace clerestory
