// The uniform blocks of materials, as shaders/include/blocks.glsl declares them.
#pragma once

#include "gl/buffer.h"
#include "passes/blocks.h"
#include "scene/material.h"

#include <cstddef>
#include <span>

namespace clerestory {

// The uniform block of a material; tables for ray tracing have the same layout.
blocks::MaterialBlock materialBlock(const Material& material);
blocks::LayerBlock layerBlock(const Material& material);

// The blocks of materials and of their layers, each at a multiple of the driver's alignment.
class MaterialBlocks {
public:
    void assign(std::span<const Material> materials);
    void bind(std::size_t place, bool layers) const;

private:
    gl::Buffer buffer_;
};

}  // namespace clerestory
