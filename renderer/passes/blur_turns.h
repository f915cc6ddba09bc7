// The turns about an axis that a Gaussian blur of a cube adds up.
#pragma once

#include "scene/map_blur.h"

#include <glm/glm.hpp>

#include <vector>

namespace clerestory {

// Cosine and sine of each turn, z: its weight; the weights add up to 1. At most four for each texel
// of the half-width, and one. The blur changes something.
std::vector<glm::vec4> blurTurns(const MapBlur& blur, std::uint32_t faceSize);

}  // namespace clerestory
