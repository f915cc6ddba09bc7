// A ray through the posed scene, and the point of a triangle that it hits.
#pragma once

#include <glm/glm.hpp>

#include <cstdint>
#include <limits>

namespace clerestory::reference {

inline constexpr std::uint32_t kNoTriangle = 0xffffffffu;

struct Ray {
    glm::dvec3 origin{
        0.0};  // relative to SceneGeometry::origin(), world axes, as all positions here
    glm::dvec3 direction{0.0};  // unit
    double tMin = 0.0, tMax = std::numeric_limits<double>::infinity();
    std::uint32_t originTriangle = kNoTriangle;  // the triangle it starts on, which is not hit
};

struct Hit {
    double distance = 0.0;
    double weightB = 0.0, weightC = 0.0;  // barycentric, of the second and third corner
    std::uint32_t triangle = 0;
};

}  // namespace clerestory::reference
