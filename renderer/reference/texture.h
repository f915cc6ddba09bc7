// Textures as they are: the finest level, bilinear between its texels. What a pixel averages is the
// samples' affair.
#pragma once

#include "scene/scene.h"

namespace clerestory::reference {

// Linear values at texture coordinates (v = 0 is the first row). White where the slot is empty.
glm::dvec4 textureAt(const Scene& scene, const TextureSlot& slot, const Vertex& a, const Vertex& b,
                     const Vertex& c, double weightB, double weightC);

}  // namespace clerestory::reference
