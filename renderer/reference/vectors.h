// Vector functions of the path tracer. All values are double: as fast as float here, and formulae
// need no special cases for rounding.
#pragma once

#include <glm/glm.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace clerestory::reference {

inline constexpr double kPi = std::numbers::pi;

inline double greatest(const glm::dvec3& v) {
    return std::max({v.x, v.y, v.z});
}
inline double luminance(const glm::dvec3& c) {
    return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z;
}

// v normalised; `otherwise` if its length is 0, not finite or out of range.
inline glm::dvec3 unitOr(const glm::dvec3& v, const glm::dvec3& otherwise) {
    const double squared = glm::dot(v, v);
    return squared > 1e-60 && squared < 1e60 ? v / std::sqrt(squared) : otherwise;
}

// A right-handed orthonormal basis whose z is the given unit normal.
struct Frame {
    glm::dvec3 x, y, z;

    explicit Frame(const glm::dvec3& normal) : z(normal) {
        // The coordinate axis that is farthest from the normal.
        const glm::dvec3 a = glm::abs(normal);
        const glm::dvec3 axis = a.x <= a.y && a.x <= a.z ? glm::dvec3(1, 0, 0)
                                : a.y <= a.z             ? glm::dvec3(0, 1, 0)
                                                         : glm::dvec3(0, 0, 1);
        x = glm::normalize(glm::cross(axis, normal));
        y = glm::cross(normal, x);
    }
    // along: unit, perpendicular to the normal.
    Frame(const glm::dvec3& normal, const glm::dvec3& along)
        : x(along), y(glm::cross(normal, along)), z(normal) {}
    glm::dvec3 toWorld(const glm::dvec3& v) const { return v.x * x + v.y * y + v.z * z; }
    glm::dvec3 toLocal(const glm::dvec3& v) const {
        return {glm::dot(v, x), glm::dot(v, y), glm::dot(v, z)};
    }
};

}  // namespace clerestory::reference
