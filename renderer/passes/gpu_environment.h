// An uploaded environment map: a cube at its original resolution with averaged levels, and its nine
// diffuse harmonics. The sky shows it and prefiltering reads it.
#pragma once

#include "gl/texture.h"
#include "scene/environment.h"

#include <array>

namespace clerestory {

struct GpuEnvironment {
    explicit GpuEnvironment(const EnvironmentMap& map);

    gl::Texture source;
    std::array<glm::vec3, 9> harmonics;
};

// Halves the edge of a face, rounded down; each texel is the mean of the four that it covers.
std::vector<glm::vec3> halvedFace(const std::vector<glm::vec3>& face, std::uint32_t size);

}  // namespace clerestory
