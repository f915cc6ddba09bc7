// Sample directions of the passes over cubes: prefiltering by a GGX lobe, and Gaussian blur.
#pragma once

#include "scene/material.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <vector>

namespace clerestory {

// GGX importance samples. xyz: direction to the light, for the normal +Z, which is also the
// direction to the eye; w: level of the source cube. Between one and PREFILTER_SAMPLES samples, all
// above the horizon. roughness: 0..1; face sizes: texels.
std::vector<glm::vec4> environmentSamples(float roughness, std::uint32_t count,
                                          float sourceFaceSize, float targetFaceSize);

// Rotations about an axis whose weighted sum is a Gaussian blur of a cube. x, y: cosine and sine of
// the angle; z: weight; the weights add up to 1. At most 4 size + 1. Requires blur.changes();
// faceSize: texels.
std::vector<glm::vec4> blurRotations(const MapBlur& blur, std::uint32_t faceSize);

}  // namespace clerestory
