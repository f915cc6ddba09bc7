// An environment map as it was given: a cube at its own resolution with levels averaged here, and
// its nine harmonics. What the sky shows and the environment pass reads.
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

// Half as large along each edge, rounded down: each texel is the mean of the four it covers.
std::vector<glm::vec3> halvedFace(const std::vector<glm::vec3>& face, std::uint32_t size);

}  // namespace clerestory
