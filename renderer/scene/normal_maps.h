// Normal maps after import: what the planner and the shaders need to know of them, and normal maps
// and metallic-roughness maps combined into one texture each, so that shaders sample fewer
// textures.
#pragma once

#include "scene/scene.h"

namespace clerestory {

// Stores x and y of the normal in R and A and the metallic-roughness map in G and B
// (TextureImage::packedNormal), and removes a metallic-roughness map that is no longer used.
// Normals are normalised on every level; z follows from x and y, since it is never negative in
// glTF. Applies only to pairs of linear images of equal size, if the normal map has no other use
// and every material that uses it samples the other map with the same coordinates, transform and
// sampler.
// First sets TextureImage::slope of every normal map.
void packNormals(Scene& scene);

}  // namespace clerestory
