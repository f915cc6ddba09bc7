// All pictures of a scene in one list of texels, each with its levels, for hits of rays: nobody can
// bind a texture for a surface that is only known once a ray has met it.
#pragma once

#include "gl/texture.h"
#include "scene/scene.h"

#include <cstddef>
#include <vector>

namespace clerestory {

struct TracedTexels {
    // RGBA, 8 bits each. What a picture keeps in sRGB is kept here as its square root, which a
    // shader takes back with one multiplication; half a step of 8 bits is lost on the way.
    std::vector<std::byte> bytes;
    // TRACE_TEXTURE_ROWS for each of Scene::textures: levels, wrapping of u and v (Wrap), 1 if
    // magnified smoothly + 2 if a square root; then for each level: number of its first texel,
    // divided by 4096 and the rest; width; height.
    std::vector<glm::vec4> rows;
};

// Limit of the copied texels of a scene, four bytes each; larger levels are omitted.
inline constexpr std::uint64_t kMaxTracedTexels = 32'000'000;

// `images` as Scene::images, on the GPU. The largest levels are left out until the texels are at
// most kMaxTracedTexels.
TracedTexels tracedTexels(const Scene& scene, const std::vector<gl::Texture>& images);

}  // namespace clerestory
