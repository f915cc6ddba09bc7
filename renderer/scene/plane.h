// Planes in double: n.x + offset = 0, n a unit vector; the front is the side that n points to.
#pragma once

#include <glm/glm.hpp>

#include <optional>

namespace clerestory {

struct Plane {
    glm::dvec3 normal{0.0, 0.0, 1.0};
    double offset = 0.0;

    // Signed, positive in front. (Erratum P2: the plane's point nearest the origin is
    // -offset * normal.)
    double distance(const glm::dvec3& point) const { return glm::dot(normal, point) + offset; }
};

// A plane is a covector: its normal goes through the cofactors, times the determinant's sign, so
// that the front stays the front (erratum P1). Cofactors exist for singular matrices too, so a
// flattened mirror is still one. Nothing when the matrix leaves a line or a point of the plane, or
// is not finite.
std::optional<Plane> transformed(const Plane& plane, const glm::dmat4& worldFromLocal);

}  // namespace clerestory
