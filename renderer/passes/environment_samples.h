// Which directions a prefiltered environment map adds up, and how blurred it reads each.
#pragma once

#include <glm/glm.hpp>

#include <cstdint>
#include <vector>

namespace clerestory {

// toLight about the normal +Z, w: level of the source cube. The normal is taken for the direction
// to the eye as well. At least one sample, at most PREFILTER_SAMPLES, none below the horizon.
std::vector<glm::vec4> environmentSamples(float roughness, std::uint32_t count,
                                          float sourceFaceSize, float targetFaceSize);

}  // namespace clerestory
