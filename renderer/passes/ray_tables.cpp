#include "passes/ray_tables.h"

#include "passes/blocks.h"
#include "passes/draw_stream.h"
#include "passes/material_blocks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace clerestory {
namespace {

glm::uvec2 sizeOf(const TextureImage& image, std::uint32_t level) {
    return {std::max(1u, image.width >> level), std::max(1u, image.height >> level)};
}

// The first level that is at most `edge` texels wide and high.
std::uint32_t firstLevel(const TextureImage& image, std::uint32_t edge) {
    std::uint32_t level = 0;
    while (level + 1 < image.levels && std::max(image.width, image.height) >> level > edge) ++level;
    return level;
}

std::uint64_t texelsBelow(const Scene& scene, std::uint32_t edge) {
    std::uint64_t sum = 0;
    for (const TextureImage& image : scene.images) {
        for (std::uint32_t level = firstLevel(image, edge); level < image.levels; ++level) {
            const glm::uvec2 size = sizeOf(image, level);
            sum += std::uint64_t{size.x} * size.y;
        }
    }
    return sum;
}

std::array<std::uint8_t, 256> rootOfSrgb() {
    std::array<std::uint8_t, 256> table{};
    for (int i = 0; i < 256; ++i) {
        const double x = i / 255.0;
        const double linear = x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
        table[i] = static_cast<std::uint8_t>(std::lround(255.0 * std::sqrt(linear)));
    }
    return table;
}

void takeRoots(std::span<std::byte> rgba) {
    static const std::array<std::uint8_t, 256> root = rootOfSrgb();
    for (std::size_t i = 0; i < rgba.size(); ++i) {
        if (i % 4 != 3) rgba[i] = std::byte{root[std::to_integer<std::uint8_t>(rgba[i])]};
    }
}

float flagsOf(const Scene& scene, const Material& m,
              const RayScene::MaterialProperties& properties) {
    int flags = 0;
    if (m.alphaMode == AlphaMode::mask) flags |= TRACE_MASK;
    if (m.alphaMode == AlphaMode::blend) flags |= TRACE_BLEND;
    if (m.doubleSided) flags |= TRACE_DOUBLE_SIDED;
    if (m.unlit) flags |= TRACE_UNLIT;
    if (m.normalTexture.present() &&
        scene.images[scene.textures[m.normalTexture.texture].image].packedNormal) {
        flags |= TRACE_PACKED_NORMAL;
    }
    if (properties.mirrorsWhereFlat) flags |= TRACE_MIRROR_FLAT;
    if (properties.mirrorsWhereCurved) flags |= TRACE_MIRROR_CURVED;
    return static_cast<float>(flags);
}

// A MaterialBlock and a LayerBlock with the flags and the texture of each slot (1 + index, 0: none)
// in unused components.
void appendMaterial(std::vector<glm::vec4>& rows, const Scene& scene, const Material& m,
                    const RayScene::MaterialProperties& properties) {
    blocks::MaterialBlock block = materialBlock(m);
    block.attenuation.w = flagsOf(scene, m, properties);
    blocks::LayerBlock layers = layerBlock(m);
    // A slot without a texture reads white: the greatest thickness, as a film without a texture
    // has.
    const auto slots = textureSlots(m);
    for (std::size_t s = 0; s < slots.size(); ++s) {
        glm::vec4* slotRows = s < BASE_SLOTS ? &block.texCoordRows[2 * s]
                                             : &layers.texCoordRows[2 * (s - BASE_SLOTS)];
        slotRows[1].w = slots[s]->present() ? static_cast<float>(slots[s]->texture + 1) : 0.0f;
    }
    static_assert(sizeof block == TRACE_LAYERS * sizeof(glm::vec4));
    static_assert(sizeof block + sizeof layers == TRACE_MATERIAL_ROWS * sizeof(glm::vec4));
    const std::size_t first = rows.size();
    rows.resize(first + TRACE_MATERIAL_ROWS);
    std::memcpy(rows.data() + first, &block, sizeof block);
    std::memcpy(rows.data() + first + TRACE_LAYERS, &layers, sizeof layers);
}

int flagOf(Glass glass) {
    switch (glass) {
        case Glass::none:
            return 0;
        case Glass::pane:
            return TRACE_PANE;
        case Glass::solid:
            return TRACE_SOLID;
    }
    return 0;
}

}  // namespace

std::vector<glm::vec4> materialRows(const Scene& scene, const FramePlan& plan) {
    std::vector<glm::vec4> rows;
    auto properties = plan.rays->materials.begin();
    for (const Material& m : scene.materials) appendMaterial(rows, scene, m, *properties++);
    for (const Material& m : plan.materials) appendMaterial(rows, scene, m, *properties++);
    return rows;
}

std::vector<glm::vec4> instanceRows(const Scene& scene, const RayScene& rays, DrawStream& draws) {
    std::vector<glm::vec4> rows;
    rows.reserve(TRACE_INSTANCE_ROWS * scene.instances.size());
    for (Index i = 0; i < scene.instances.size(); ++i) {
        const DrawRecord& record = draws.record(i);
        const std::vector<std::uint8_t>& lights = rays.instances[i].lights;
        const Index material = rays.materialOfInstance.empty() ? scene.instances[i].material
                                                               : rays.materialOfInstance[i];
        for (int row = 0; row < 3; ++row) rows.push_back(record.normalFromModel[row]);
        for (int row = 0; row < 3; ++row) rows.push_back(record.eyeFromModel[row]);
        glm::vec4* instance = rows.data() + rows.size() - (TRACE_INSTANCE_ROWS - 1);
        instance[0].w = static_cast<float>(material);
        instance[1].w = static_cast<float>(draws.firstLight(lights));
        instance[2].w = static_cast<float>(lights.size());
        const glm::mat3 linear(instance[3], instance[4], instance[5]);  // its transpose
        instance[3].w = draws.mirrored(i) ? -1.0f : 1.0f;
        instance[5].w = static_cast<float>(flagOf(rays.instances[i].glass));
        rows.emplace_back(draws.firstLightValue(i), 0.0f, 0.0f, 0.0f);
        instance = rows.data() + rows.size() - TRACE_INSTANCE_ROWS;
        instance[4].w = std::cbrt(std::abs(glm::determinant(linear)));
    }
    if (rows.empty()) rows.resize(1);
    return rows;
}

TracedTexels tracedTexels(const Scene& scene,
                          std::span<const std::shared_ptr<const gl::Texture>> images) {
    std::uint32_t edge = 1u << 15;
    while (edge > 1 && texelsBelow(scene, edge) > kMaxTracedTexels) edge /= 2;

    TracedTexels result;
    const auto bytes = static_cast<std::size_t>(4 * texelsBelow(scene, edge));
    // Not filled with zeros first; without images it is one black texel.
    auto memory = bytes > 0 ? std::make_unique_for_overwrite<std::byte[]>(bytes)
                            : std::make_unique<std::byte[]>(4);
    result.bytes = {memory.get(), std::max<std::size_t>(bytes, 4)};
    std::vector<std::vector<glm::vec4>> levelsOf(scene.images.size());
    std::size_t texel = 0;
    for (std::size_t i = 0; i < scene.images.size(); ++i) {
        const TextureImage& image = scene.images[i];
        for (std::uint32_t level = firstLevel(image, edge); level < image.levels; ++level) {
            const glm::uvec2 size = sizeOf(image, level);
            const std::size_t count = std::size_t{size.x} * size.y;
            const std::span<std::byte> texels =
                std::span(memory.get(), bytes).subspan(4 * texel, 4 * count);
            images[i]->read(level, texels);
            if (image.colorSpace == ColorSpace::srgb) takeRoots(texels);
            levelsOf[i].emplace_back(texel / 4096, texel % 4096, size.x, size.y);
            texel += count;
        }
    }
    for (const Texture& texture : scene.textures) {
        const std::size_t first = result.rows.size();
        result.rows.resize(first + TRACE_TEXTURE_ROWS);
        const std::vector<glm::vec4>& levels = levelsOf[texture.image];
        const std::size_t count =
            texture.useLevels ? std::min<std::size_t>(levels.size(), TRACE_TEXTURE_ROWS - 1) : 1;
        const bool smooth = texture.magnify == Filter::linear;
        const bool root = scene.images[texture.image].colorSpace == ColorSpace::srgb;
        result.rows[first] = {count, static_cast<float>(texture.wrapU),
                              static_cast<float>(texture.wrapV),
                              (smooth ? 1.0f : 0.0f) + (root ? 2.0f : 0.0f)};
        std::copy_n(levels.begin(), count,
                    result.rows.begin() + static_cast<std::ptrdiff_t>(first) + 1);
    }
    result.memory = std::move(memory);
    return result;
}

}  // namespace clerestory
