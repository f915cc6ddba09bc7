// Mip levels of a picture, made on the CPU: the driver's own take longer to start, and are not
// averaged in linear light.
#pragma once

#include "scene/material.h"

namespace clerestory {

// From level 0 in `texels` (width * height * 4 bytes) to all levels down to 1x1. Colour is averaged
// in linear light, weighted by nothing; an odd edge's last texel is averaged with its neighbour
// alone. Sets levels, texels, mean and hasAlpha.
void buildLevels(TextureImage& image);

}  // namespace clerestory
