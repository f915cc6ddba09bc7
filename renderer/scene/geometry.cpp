#include "scene/geometry.h"

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include <algorithm>
#include <cmath>

namespace clerestory {
namespace {

// a * b - c * d, accurate to two rounding errors even if the products almost cancel (Kahan).
double differenceOfProducts(double a, double b, double c, double d) {
    const double cd = c * d;
    return std::fma(a, b, -cd) + std::fma(-c, d, cd);
}

glm::dvec3 exactCross(const glm::dvec3& a, const glm::dvec3& b) {
    return {differenceOfProducts(a.y, b.z, a.z, b.y), differenceOfProducts(a.z, b.x, a.x, b.z),
            differenceOfProducts(a.x, b.y, a.y, b.x)};
}

glm::dmat3 cofactors(const glm::dmat3& m) {
    return {glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1])};
}

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

bool inReach(const Bounds& box) {
    const glm::vec3 farthest(kMaxCoordinate);
    return glm::all(glm::lessThan(glm::abs(box.min), farthest)) &&
           glm::all(glm::lessThan(glm::abs(box.max), farthest));
}

bool inReach(const glm::dmat4& m) {
    const glm::dvec4 farthest(1e30);
    bool all = true;
    for (int column = 0; column < 4; ++column) {
        all = all && glm::all(glm::lessThan(glm::abs(m[column]), farthest));
    }
    return all;
}

Bounds transformed(const Bounds& box, const glm::dmat4& toFromBox) {
    if (box.empty()) return box;
    // Arvo 1990: each axis sums the smaller and the larger products.
    glm::dvec3 low(toFromBox[3]), high(toFromBox[3]);
    for (int column = 0; column < 3; ++column) {
        const glm::dvec3 axis(toFromBox[column]);
        const glm::dvec3 a = axis * static_cast<double>(box.min[column]);
        const glm::dvec3 b = axis * static_cast<double>(box.max[column]);
        low += glm::min(a, b);
        high += glm::max(a, b);
    }
    Bounds result;
    result.min = glm::vec3(low);
    result.max = glm::vec3(high);
    return result;
}

std::optional<Plane> transformed(const Plane& plane, const glm::dmat4& worldFromLocal) {
    const glm::dvec3 x(worldFromLocal[0]), y(worldFromLocal[1]), z(worldFromLocal[2]);
    const glm::dvec3& n = plane.normal;
    const glm::dvec3 cofactor =
        n.x * exactCross(y, z) + n.y * exactCross(z, x) + n.z * exactCross(x, y);
    // The magnitude without cancellation: results far below it are rounding errors.
    const double lx = glm::length(x), ly = glm::length(y), lz = glm::length(z);
    const double scale =
        std::abs(n.x) * ly * lz + std::abs(n.y) * lz * lx + std::abs(n.z) * lx * ly;
    constexpr double kOnlyRounding = 1e-15;
    const double length = glm::length(cofactor);
    if (!(length > kOnlyRounding * scale) || !std::isfinite(length)) return std::nullopt;

    const double side = glm::dot(x, exactCross(y, z)) < 0.0 ? -1.0 : 1.0;
    Plane world;
    world.normal = cofactor * (side / length);
    const glm::dvec3 point(worldFromLocal * glm::dvec4(-plane.offset * n, 1.0));
    world.offset = -glm::dot(world.normal, point);
    if (!std::isfinite(world.offset)) return std::nullopt;
    return world;
}

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

glm::dmat3 normalMatrix(const glm::dmat3& m) {
    double largest = 0.0;
    for (int i = 0; i < 3; ++i) {
        largest = std::max({largest, std::abs(m[i].x), std::abs(m[i].y), std::abs(m[i].z)});
    }
    if (!(largest > 0.0)) return glm::dmat3(1.0);
    const glm::dmat3 unit = m / largest;
    glm::dmat3 normals = cofactors(unit);
    if (glm::determinant(unit) < 0.0) normals = -normals;
    largest = 0.0;
    for (int i = 0; i < 3; ++i) {
        largest = std::max(
            {largest, std::abs(normals[i].x), std::abs(normals[i].y), std::abs(normals[i].z)});
    }
    return largest > 0.0 ? normals / largest : glm::dmat3(1.0);
}

}  // namespace clerestory
