#include "scene/plane.h"

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

}  // namespace

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

}  // namespace clerestory
