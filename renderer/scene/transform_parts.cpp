#include "scene/transform_parts.h"

#include <algorithm>
#include <cmath>

namespace clerestory {
namespace {

// Relative to the product of the lengths of its axes: below this a matrix is as good as flat.
constexpr double kLeastVolume = 1e-9;
constexpr double kMaxAxis = 1e6, kMinAxis = 1e-9;

glm::dmat4 matrixOf(const std::array<double, 16>& m) {
    glm::dmat4 matrix;
    std::copy(m.begin(), m.end(), &matrix[0][0]);
    return matrix;
}

// Empty, or why the matrix is no transform of a node.
std::string problemOf(const glm::dmat4& m) {
    if (m[0].w != 0.0 || m[1].w != 0.0 || m[2].w != 0.0 || m[3].w != 1.0) return "is not affine";
    const glm::dvec3 x(m[0]), y(m[1]), z(m[2]);
    const double lengths[] = {glm::length(x), glm::length(y), glm::length(z)};
    for (const double length : lengths) {
        if (!(length <= kMaxAxis)) return "is too large";
        if (!(length >= kMinAxis)) return "is singular";
    }
    const double volume = std::abs(glm::dot(x, glm::cross(y, z)));
    if (!(volume > kLeastVolume * lengths[0] * lengths[1] * lengths[2])) return "is singular";
    return {};
}

}  // namespace

std::vector<FieldError> problems(const TransformParts& parts, const std::string& pointer) {
    std::vector<FieldError> errors;
    if (parts.matrix && (parts.translation || parts.rotation || parts.scale)) {
        errors.push_back({pointer + "/matrix", "conflicts with another form of the transform",
                          "matrix, or translation, rotation and scale"});
    }
    if (parts.matrix) {
        if (const std::string problem = problemOf(matrixOf(*parts.matrix)); !problem.empty()) {
            errors.push_back({pointer + "/matrix", problem,
                              "an invertible affine matrix whose axes have lengths from 1e-9 to "
                              "1e6; last row 0 0 0 1"});
        }
    }
    const auto flat = [](double factor) { return !(std::abs(factor) >= kMinAxis); };
    if (parts.scale && (flat(parts.scale->x) || flat(parts.scale->y) || flat(parts.scale->z))) {
        errors.push_back({pointer + "/scale", "is singular",
                          "factors whose absolute value is from 1e-9 to 1e6"});
    }
    return errors;
}

Transform transformOf(const glm::dmat4& matrix) {
    Transform t{.translation = glm::dvec3(matrix[3])};
    glm::dmat3 axes(matrix);
    for (int i = 0; i < 3; ++i) {
        t.scale[i] = glm::length(axes[i]);
        axes[i] = t.scale[i] > 0.0 ? axes[i] / t.scale[i] : glm::dmat3(1.0)[i];
    }
    if (glm::determinant(axes) < 0.0) {
        t.scale.x = -t.scale.x;
        axes[0] = -axes[0];
    }
    const glm::dquat q = glm::quat_cast(axes);
    if (glm::length(q) > 1e-6) t.rotation = glm::normalize(q);
    return t;
}

glm::dmat4 changed(const glm::dmat4& own, const TransformParts& parts) {
    if (parts.matrix) return matrixOf(*parts.matrix);
    glm::dmat4 m = own;
    if (parts.rotation || parts.scale) {
        Transform t = transformOf(own);
        if (const auto& q = parts.rotation) {
            t.rotation = glm::normalize(glm::dquat((*q)[3], (*q)[0], (*q)[1], (*q)[2]));
        }
        if (parts.scale) t.scale = *parts.scale;
        m = clerestory::matrixOf(t);
    }
    if (parts.translation) m[3] = glm::dvec4(*parts.translation, 1.0);
    return m;
}

}  // namespace clerestory
