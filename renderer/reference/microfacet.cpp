#include "reference/microfacet.h"

#include "reference/vectors.h"

#include <array>

namespace clerestory::reference {
namespace {

// Smith's Lambda: facets hidden for each one that is not.
double hiddenFor(const glm::dvec3& v, double alpha) {
    const double z2 = v.z * v.z;
    if (z2 <= 0.0) return 1e9;
    return 0.5 * (std::sqrt(1.0 + alpha * alpha * (v.x * v.x + v.y * v.y) / z2) - 1.0);
}

}  // namespace

double facetDensity(const glm::dvec3& normal, double alpha) {
    if (normal.z <= 0.0) return 0.0;
    const double a2 = alpha * alpha;
    const double k = normal.x * normal.x + normal.y * normal.y + a2 * normal.z * normal.z;
    return a2 / (kPi * k * k);
}

double facetMean(const glm::dvec3& normal, double alpha, double covered) {
    if (normal.z <= 0.0) return 0.0;
    if (covered < 1e-9 * alpha * alpha) return facetDensity(normal, alpha);
    const double z2 = normal.z * normal.z, a2 = alpha * alpha;
    const double slope2 = (normal.x * normal.x + normal.y * normal.y) / z2;
    // (1 - a / s) / (2 covered), of which the other form keeps its digits where the disc is far.
    const double a = a2 + slope2 - covered, s = std::sqrt(a * a + 4.0 * a2 * covered);
    const double mean = a > 0.0 ? 2.0 * a2 / (s * (s + a)) : (s - a) / (2.0 * covered * s);
    return mean / (kPi * z2 * z2);
}

double unhidden(const glm::dvec3& v, double alpha) {
    return 1.0 / (1.0 + hiddenFor(v, alpha));
}

double unhiddenFromBoth(const glm::dvec3& v, const glm::dvec3& l, double alpha) {
    return 1.0 / (1.0 + hiddenFor(v, alpha) + hiddenFor(l, alpha));
}

glm::dvec3 visibleFacet(const glm::dvec3& v, double alpha, const glm::dvec2& random) {
    // Stretched, the facets are a half sphere; what it mirrors of v is a spherical cap.
    const glm::dvec3 stretched =
        unitOr({alpha * v.x, alpha * v.y, std::max(v.z, 0.0)}, glm::dvec3(0, 0, 1));
    const double turn = 2.0 * kPi * random.x;
    const double z = (1.0 - random.y) * (1.0 + stretched.z) - stretched.z;
    const double across = std::sqrt(std::clamp(1.0 - z * z, 0.0, 1.0));
    const glm::dvec3 half =
        glm::dvec3(across * std::cos(turn), across * std::sin(turn), z) + stretched;
    return unitOr({alpha * half.x, alpha * half.y, std::max(half.z, 0.0)}, glm::dvec3(0, 0, 1));
}

double visibleFacetDensity(const glm::dvec3& v, const glm::dvec3& normal, double alpha) {
    const double z = std::max(v.z, 1e-9);
    return unhidden(v, alpha) * std::max(glm::dot(v, normal), 0.0) * facetDensity(normal, alpha) /
           z;
}

double mirroredDensity(const glm::dvec3& v, const glm::dvec3& l, double alpha) {
    const glm::dvec3 half = unitOr(v + l, glm::dvec3(0, 0, 1));
    const double cosine = glm::dot(v, half);
    return cosine > 0.0 ? visibleFacetDensity(v, half, alpha) / (4.0 * cosine) : 0.0;
}

namespace {

constexpr int kTableSize = 48;  // even in the root of the cosine and in the root of alpha
constexpr int kTableSamples = 32 * 32;

double returnedOnceExactly(double cosine, double alpha) {
    if (alpha < kMinReferenceAlpha) return 1.0;
    const double c = std::max(cosine, 1e-4);
    const glm::dvec3 v(std::sqrt(1.0 - c * c), 0.0, c);
    double sum = 0.0;
    for (int i = 0; i < kTableSamples; ++i) {
        const glm::dvec2 random((i % 32 + 0.5) / 32, (i / 32 + 0.5) / 32);
        const glm::dvec3 facet = visibleFacet(v, alpha, random);
        const glm::dvec3 l = 2.0 * glm::dot(v, facet) * facet - v;
        if (l.z > 0.0) sum += unhiddenFromBoth(v, l, alpha) / unhidden(v, alpha);
    }
    return sum / kTableSamples;
}

using Table = std::array<std::array<double, kTableSize>, kTableSize>;

const Table& returnedTable() {
    static const Table table = [] {
        Table t{};
        for (int row = 0; row < kTableSize; ++row) {
            const double roughness = double(row) / (kTableSize - 1);
            for (int column = 0; column < kTableSize; ++column) {
                const double root = double(column) / (kTableSize - 1);
                t[row][column] = returnedOnceExactly(root * root, roughness * roughness);
            }
        }
        return t;
    }();
    return table;
}

}  // namespace

double returnedOnce(double cosine, double alpha) {
    const Table& table = returnedTable();
    const double x = std::sqrt(std::clamp(cosine, 0.0, 1.0)) * (kTableSize - 1);
    const double y = std::sqrt(std::clamp(alpha, 0.0, 1.0)) * (kTableSize - 1);
    const int column = std::min(int(x), kTableSize - 2), row = std::min(int(y), kTableSize - 2);
    const auto along = [&](int r) {
        return std::lerp(table[r][column], table[r][column + 1], x - column);
    };
    return std::lerp(along(row), along(row + 1), y - row);
}

glm::dvec3 bouncesFactor(const glm::dvec3& f0, double cosine, double alpha) {
    return 1.0 + f0 * (1.0 / std::max(returnedOnce(cosine, alpha), 0.05) - 1.0);
}

}  // namespace clerestory::reference
