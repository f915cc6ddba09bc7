// Mip levels of texture images, computed on the CPU, because drivers start more slowly and do not
// average in linear light.
#pragma once

#include "scene/material.h"

namespace clerestory {

// Extends `texels` from level 0 (width * height * 4 bytes) to all levels down to 1x1. Averages in
// linear light, not weighted by alpha. Sets levels, texels, mean, leastGreen and hasAlpha.
void buildLevels(TextureImage& image);

}  // namespace clerestory
