// Tables for ray tracing in the layout that shaders/include/hit.glsl reads, whether on the GPU or
// on the processor.
#pragma once

#include "gl/texture.h"
#include "plan/graph/frame_plan.h"
#include "scene/scene.h"

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace clerestory {

class DrawStream;

// TRACE_MATERIAL_ROWS for each of Scene::materials, then for each of FramePlan::materials. Requires
// plan.rays.
std::vector<glm::vec4> materialRows(const Scene& scene, const FramePlan& plan);

// TRACE_INSTANCE_ROWS for each instance: transforms to the eye space of the view that `draws` was
// begun with, material and lights. Adds the lists of lights to `draws`. At least one row.
std::vector<glm::vec4> instanceRows(const Scene& scene, const RayScene& rays, DrawStream& draws);

// All images of a scene with their levels as one list of texels: the texture of a hit is not known
// in advance, so that it cannot be bound.
struct TracedTexels {
    // RGBA, 8 bits each. sRGB images are stored as square roots of linear values, which a shader
    // decodes with one multiplication; this costs half a step of 8 bits.
    std::span<const std::byte> bytes;
    std::unique_ptr<const std::byte[]> memory;  // of `bytes`
    // TRACE_TEXTURE_ROWS for each of Scene::textures. First row: number of levels, wrapping of u
    // and v (Wrap), 1 for bilinear magnification + 2 for square roots. One row per level: index of
    // its first texel as quotient and remainder of 4096, width, height.
    std::vector<glm::vec4> rows;
};

// Limit of the copied texels of a scene, four bytes each; larger levels are omitted.
inline constexpr std::uint64_t kMaxTracedTexels = 32'000'000;

// `images` as Scene::images, on the GPU. The largest levels are left out until the texels are at
// most kMaxTracedTexels.
TracedTexels tracedTexels(const Scene& scene,
                          std::span<const std::shared_ptr<const gl::Texture>> images);

}  // namespace clerestory
