#include "plan/visibility/coverage.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace clerestory {
namespace {

constexpr int kCells = 64;  // along each axis of the grid; bits of a row

// The half-open range of cells of [low, high] that an interval touches.
std::array<int, 2> cellsOf(double from, double to, double low, double high) {
    const auto cell = [&](double v) {
        return std::clamp((v - low) / (high - low), 0.0, 1.0) * kCells;
    };
    return {static_cast<int>(std::floor(cell(from))), static_cast<int>(std::ceil(cell(to)))};
}

}  // namespace

double unionShare(std::span<const ScreenBox> boxes) {
    ScreenBox all;
    double sum = 0.0;
    for (const ScreenBox& box : boxes) {
        if (box.empty()) continue;
        all.low = glm::min(all.low, box.low);
        all.high = glm::max(all.high, box.high);
        sum += box.share();
    }
    if (all.empty()) return 0.0;
    std::array<std::uint64_t, kCells> rows{};
    for (const ScreenBox& box : boxes) {
        if (box.empty()) continue;
        const auto [left, right] = cellsOf(box.low.x, box.high.x, all.low.x, all.high.x);
        const auto [bottom, top] = cellsOf(box.low.y, box.high.y, all.low.y, all.high.y);
        if (right <= left) continue;
        const std::uint64_t row = (~std::uint64_t{0} >> (kCells - (right - left))) << left;
        for (int y = bottom; y < top; ++y) rows[y] |= row;
    }
    int cells = 0;
    for (const std::uint64_t row : rows) cells += std::popcount(row);
    return std::min({1.0, sum, all.share() * cells / (kCells * kCells)});
}

double areaShare(const View& view, const Bounds& box, double area) {
    if (box.empty()) return 0.0;
    // Fraction of the picture that an area of 1 facing the eye at depth 1 covers.
    const double perArea = 0.25 * std::abs(view.clipFromView[0][0] * view.clipFromView[1][1]);
    const glm::dvec3 forward = -glm::transpose(glm::dmat3(view.viewFromWorld))[2];
    const double half = glm::dot(glm::abs(forward), 0.5 * glm::dvec3(box.extent()));
    const double nearest = glm::dot(forward, glm::dvec3(box.center())) - half;
    // Outline of a convex body, mean over directions, relative to its surface: 1/4 (Cauchy).
    constexpr double kOutline = 0.25;
    if (view.orthographic) return perArea * area * kOutline;
    if (!(nearest > 0.0)) return 2.0;  // reaches behind the eye
    // The mean of 1 / depth^2 over an interval of depths is 1 / (nearest * farthest).
    return perArea * area * kOutline / (nearest * (nearest + 2.0 * half));
}

double transformedArea(const glm::dmat4& worldFromMesh, double area,
                       const std::optional<glm::dvec3>& normal) {
    const glm::dmat3 m(worldFromMesh);
    if (!normal) return area * std::pow(std::abs(glm::determinant(m)), 2.0 / 3.0);
    const glm::dvec3 n = *normal;
    const glm::dvec3 other = std::abs(n.x) < 0.7 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 along = glm::normalize(glm::cross(n, other));
    return area * glm::length(glm::cross(m * along, m * glm::cross(n, along)));
}

double shareOf(const View& view, std::span<const ScreenBox> clusters, const Bounds& box,
               double area) {
    double sum = 0.0;
    for (const ScreenBox& cluster : clusters) sum += cluster.share();
    return std::min({1.0, kBoxFill * sum, unionShare(clusters), areaShare(view, box, area)});
}

}  // namespace clerestory
