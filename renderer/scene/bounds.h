// Axis-aligned bounding boxes. Units are those of their space (metres in world space).
#pragma once

#include "scene/finite.h"

#include <glm/glm.hpp>

#include <limits>

namespace clerestory {

struct Bounds {
    // The default is the empty box: min above max on every axis.
    glm::vec3 min{std::numeric_limits<float>::infinity()};
    glm::vec3 max{-std::numeric_limits<float>::infinity()};

    bool empty() const { return !(min.x <= max.x && min.y <= max.y && min.z <= max.z); }
    glm::vec3 center() const { return 0.5f * min + 0.5f * max; }
    glm::vec3 extent() const { return empty() ? glm::vec3(0.0f) : max - min; }
    float diagonal() const { return glm::length(extent()); }

    void add(const glm::vec3& point) {
        min = glm::min(min, point);
        max = glm::max(max, point);
    }
    void add(const Bounds& other) {
        if (!other.empty()) {
            add(other.min);
            add(other.max);
        }
    }
};

inline bool finite(const Bounds& box) {
    return finite(box.min) && finite(box.max);
}

// Largest absolute coordinate in world space, metres: squared lengths stay finite in float.
inline constexpr float kMaxCoordinate = 1e18f;
// Whether all coordinates are below kMaxCoordinate; false for the empty box and for NaN.
bool inReach(const Bounds& box);
// Whether all elements are below 1e30, so that products of two matrices stay finite in double.
bool inReach(const glm::dmat4& m);

// The bounds of the eight transformed corners; the empty box stays empty.
Bounds transformed(const Bounds& box, const glm::dmat4& toFromBox);

}  // namespace clerestory
