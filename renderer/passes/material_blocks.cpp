#include "passes/material_blocks.h"

#include "gl/context.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

namespace clerestory {
namespace {

// KHR_texture_transform: scale, then rotation, then offset. v points down, so that the minus sign
// of a counter-clockwise rotation is in the second row.
void setTexCoordRows(const TextureSlot& slot, glm::vec4* rows) {
    const float c = std::cos(slot.rotation), s = std::sin(slot.rotation);
    const auto set = static_cast<float>(slot.texCoord);
    rows[0] = {c * slot.scale.x, s * slot.scale.y, slot.offset.x, set};
    rows[1] = {-s * slot.scale.x, c * slot.scale.y, slot.offset.y, set};
}

std::size_t aligned(std::size_t size) {
    const std::size_t alignment = gl::Context::current().capabilities().uniformAlignment;
    return (size + alignment - 1) / alignment * alignment;
}

// A MaterialBlock, then a LayerBlock.
std::size_t layersOffset() {
    return aligned(sizeof(blocks::MaterialBlock));
}
std::size_t materialStride() {
    return layersOffset() + aligned(sizeof(blocks::LayerBlock));
}

}  // namespace

blocks::MaterialBlock materialBlock(const Material& m) {
    blocks::MaterialBlock block{};
    block.baseColor = m.baseColor;
    block.surface = {m.metallic, m.roughness, m.normalScale, m.occlusionStrength};
    block.emissive = glm::vec4(emittedRadiance(m), m.alphaCutoff);
    const float r = (m.ior - 1.0f) / (m.ior + 1.0f);  // ior is at least 1
    block.dielectricF0 =
        glm::vec4(glm::min(r * r * m.specularColor, 1.0f) * m.specular, m.specular);
    block.glass = {m.transmission, m.ior, m.thickness, m.attenuationDistance};
    // Schlick's curve reaches 1 at grazing angles for every index; the exact curve rises ever later
    // as the index approaches 1, where there is no reflection. A limit of 9 r meets the exact curve
    // at 78 degrees (index 1.02: 0.08, 1.1: 0.46).
    block.attenuation = glm::vec4(m.attenuationColor, m.specular * std::min(9.0f * r, 1.0f));
    const auto slots = textureSlots(m);
    static_assert(std::tuple_size_v<decltype(slots)> == MATERIAL_SLOTS);
    for (std::size_t i = 0; i < BASE_SLOTS; ++i) {
        setTexCoordRows(*slots[i], &block.texCoordRows[2 * i]);
    }
    block.sides.x = m.doubleSided ? 1.0f : 0.0f;
    return block;
}

blocks::LayerBlock layerBlock(const Material& m) {
    blocks::LayerBlock block{};
    block.clearcoat = {m.clearcoat, m.clearcoatRoughness, m.clearcoatNormalScale, m.dispersion};
    block.sheen = glm::vec4(m.sheenColor, m.sheenRoughness);
    block.iridescence = {m.iridescence, m.iridescenceIor, m.iridescenceThicknessMin,
                         m.iridescenceThickness};
    block.anisotropy = {m.anisotropy, std::cos(m.anisotropyRotation),
                        std::sin(m.anisotropyRotation), 0.0f};
    block.diffuseTransmission = glm::vec4(m.diffuseTransmissionColor, m.diffuseTransmission);
    const auto slots = textureSlots(m);
    for (std::size_t i = 0; i < LAYER_SLOTS; ++i) {
        setTexCoordRows(*slots[BASE_SLOTS + i], &block.texCoordRows[2 * i]);
    }
    return block;
}

void MaterialBlocks::assign(std::span<const Material> materials) {
    const std::size_t stride = materialStride();
    std::vector<std::byte> bytes(stride * std::max<std::size_t>(1, materials.size()));
    for (std::size_t i = 0; i < materials.size(); ++i) {
        const blocks::MaterialBlock block = materialBlock(materials[i]);
        std::memcpy(bytes.data() + i * stride, &block, sizeof block);
        const blocks::LayerBlock layers = layerBlock(materials[i]);
        std::memcpy(bytes.data() + i * stride + layersOffset(), &layers, sizeof layers);
    }
    buffer_.assign(bytes);
}

void MaterialBlocks::bind(std::size_t place, bool layers) const {
    const std::size_t offset = place * materialStride();
    buffer_.bindUniform(BINDING_MATERIAL, offset, sizeof(blocks::MaterialBlock));
    if (!layers) return;
    buffer_.bindUniform(BINDING_LAYERS, offset + layersOffset(), sizeof(blocks::LayerBlock));
}

}  // namespace clerestory
