// Fewer pictures to read at each pixel: metallic-roughness maps move in with the normal maps that
// surfaces read in the same places.
#pragma once

#include "scene/scene.h"

namespace clerestory {

// Puts the x and y of a normal map into R and A and the metallic-roughness map that goes with it into
// G and B (TextureImage::packedNormal); materials then read both through one texture, and a
// metallic-roughness map that nothing else needs is removed. Normals become unit vectors on the way,
// on every level; z is what is left to one, as glTF's are never negative. Only where both are linear
// and of one size, where nothing else is read from the normal map, and where every material that
// reads it reads the other alike: the same set, transform and sampling.
void packNormals(Scene& scene);

}  // namespace clerestory
