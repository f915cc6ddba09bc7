// Geometric values of scenes: axis-aligned bounding boxes, planes, rotations in the forms that
// clients and files may use, and vertices. Units are those of their space (metres in world space).
#pragma once

#include <glm/glm.hpp>

#include <array>
#include <cmath>
#include <concepts>
#include <limits>
#include <optional>
#include <span>
#include <string>

namespace clerestory {

// Whether all numbers of a value are finite: neither infinite nor NaN.
inline bool finite(std::floating_point auto value) {
    return std::isfinite(value);
}
template <int N, class T>
bool finite(const glm::vec<N, T>& v) {
    for (int i = 0; i < N; ++i) {
        if (!std::isfinite(v[i])) return false;
    }
    return true;
}
template <int C, int R, class T>
bool finite(const glm::mat<C, R, T>& m) {
    for (int i = 0; i < C; ++i) {
        if (!finite(m[i])) return false;
    }
    return true;
}

// An axis-aligned box.
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

// A plane in double: n.x + offset = 0 with a unit vector n; the front is the side that n points to.
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

using Quaternion = std::array<double, 4>;  // x y z w

inline constexpr const char* kRotationForms =
    "4 numbers: unit quaternion x y z w; 9: rotation matrix, column-major; 3: radians about X, "
    "then "
    "Y, then Z";

// Four numbers are a quaternion, nine a matrix, three angles about fixed axes. Nothing for any
// other count, or if they are not a rotation within 1e-3, which allows for rounding to float.
std::optional<Quaternion> rotationFrom(std::span<const double> numbers);

bool isUnit(const Quaternion& q);

// Attributes that the file does not have are generated or set to a neutral value by addMesh().
struct Vertex {
    glm::vec3 position{0.0f};
    glm::vec3 normal{0.0f, 0.0f, 1.0f};         // unit
    glm::vec4 tangent{1.0f, 0.0f, 0.0f, 1.0f};  // unit; w is the sign of the bitangent
    glm::vec2 texCoord0{0.0f};
    glm::vec2 texCoord1{0.0f};
    glm::vec4 color{1.0f};  // linear, multiplies baseColor
};
static_assert(sizeof(Vertex) == 72);

// Transforms normals as the inverse transpose does, and is defined for singular matrices too.
// Scaled so that its largest entry is 1, which a float represents for any scale of the scene.
glm::dmat3 normalMatrix(const glm::dmat3& m);

}  // namespace clerestory
