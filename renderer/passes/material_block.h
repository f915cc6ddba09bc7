// A material as the shaders read it, from a uniform block or from a table.
#pragma once

#include "passes/blocks.h"
#include "scene/material.h"

#include <array>

namespace clerestory {

blocks::MaterialBlock materialBlock(const Material& material);

// Where it reads textures, in the order of the block's texCoordRows.
std::array<const TextureSlot*, MATERIAL_SLOTS> textureSlots(const Material& material);

}  // namespace clerestory
