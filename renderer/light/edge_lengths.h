// How long the edges of triangles may be whose vertices show light, at any point of the world.
#pragma once

#include "scene/scene.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <vector>

namespace clerestory::light {

// There is a common length; next to bodies that are small compared with it, such as an object on a
// wide floor, light changes over a fraction of their size, and edges are shorter.
struct EdgeLengths {
    struct Body {
        Bounds box;  // world
        double size = 0.0;
        std::uint32_t instance = 0;
    };
    double common = 0.0;  // metres; 0: nothing was divided
    std::vector<Body> small;
    double perSize = 0.0;  // length at a small body, relative to its size

    // At a point of the world, next to all small bodies but that of one instance.
    double at(const glm::dvec3& world, std::uint32_t except = ~0u) const;
    // Whether it is less than `length` there.
    bool below(double length, const glm::dvec3& world, std::uint32_t except = ~0u) const;
    // Whether it may be, because of a small body, at a point of the box between two corners.
    bool belowNearBodies(double length, const glm::dvec3& low, const glm::dvec3& high,
                         std::uint32_t except = ~0u) const;
};

}  // namespace clerestory::light
