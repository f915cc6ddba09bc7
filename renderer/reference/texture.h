// Texture lookups at the finest level, bilinear. There are no mipmaps: the samples of a pixel
// average the texture.
#pragma once

#include "scene/scene.h"

namespace clerestory::reference {

// Linear values at the interpolated texture coordinates (v = 0 is the first row); white for an
// empty slot.
glm::dvec4 textureAt(const Scene& scene, const TextureSlot& slot, const Vertex& a, const Vertex& b,
                     const Vertex& c, double weightB, double weightC);

}  // namespace clerestory::reference
