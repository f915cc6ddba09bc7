// Planes in double: n.x + offset = 0 with a unit vector n; the front is the side that n points to.
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

// A plane is a covector: its normal is transformed by the cofactor matrix, times the sign of the
// determinant, so that the front stays the front (erratum P1). The cofactors of singular matrices
// exist too, so a flattened mirror remains a plane. Nothing if the matrix maps the plane to a line
// or a point, or is not finite.
std::optional<Plane> transformed(const Plane& plane, const glm::dmat4& worldFromLocal);

}  // namespace clerestory
