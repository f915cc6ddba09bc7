#include "scene/rotation.h"

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include <cmath>

namespace clerestory {
namespace {

constexpr double kUnitTolerance = 1e-3;

bool isRotation(const glm::dmat3& m) {
    const glm::dmat3 identity = glm::transpose(m) * m;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            if (!(std::abs(identity[i][j] - (i == j ? 1.0 : 0.0)) <= kUnitTolerance)) return false;
        }
    }
    return glm::determinant(m) > 0.0;
}

Quaternion numbersOf(const glm::dquat& q) {
    return {q.x, q.y, q.z, q.w};
}

}  // namespace

bool isUnit(const Quaternion& q) {
    const double square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    return std::abs(std::sqrt(square) - 1.0) <= kUnitTolerance;
}

std::optional<Quaternion> rotationFrom(std::span<const double> n) {
    if (n.size() == 3) {
        const glm::dquat x = glm::angleAxis(n[0], glm::dvec3(1, 0, 0)),
                         y = glm::angleAxis(n[1], glm::dvec3(0, 1, 0)),
                         z = glm::angleAxis(n[2], glm::dvec3(0, 0, 1));
        return numbersOf(glm::normalize(z * y * x));
    }
    if (n.size() == 4) {
        const Quaternion q{n[0], n[1], n[2], n[3]};
        return isUnit(q) ? std::optional(q) : std::nullopt;
    }
    if (n.size() == 9) {
        const glm::dmat3 m(n[0], n[1], n[2], n[3], n[4], n[5], n[6], n[7], n[8]);
        if (!isRotation(m)) return std::nullopt;
        return numbersOf(glm::normalize(glm::quat_cast(m)));
    }
    return std::nullopt;
}

}  // namespace clerestory
