#include "plan/visibility/visibility.h"

#include <algorithm>
#include <cmath>

namespace clerestory {
namespace {

glm::dmat4 clipFromEye(const View& view) {
    return view.clipFromView * glm::dmat4(glm::dmat3(view.viewFromWorld));
}

glm::dvec4 row(const glm::dmat4& m, int i) {
    return {m[0][i], m[1][i], m[2][i], m[3][i]};
}

void addCorner(ScreenBox& box, const glm::dvec4& corner) {
    const glm::dvec2 ndc = glm::dvec2(corner) / corner.w;
    box.low = glm::min(box.low, ndc);
    box.high = glm::max(box.high, ndc);
}

// A side of a box after clipping by up to five planes: four corners and one more per plane. If
// rounding makes it concave, each plane adds at most half as many, which stays below 32.
struct Polygon {
    std::array<glm::dvec4, 32> corners;
    std::size_t count = 0;
};

// The part with dot(plane, corner) >= 0 (Sutherland and Hodgman 1974).
Polygon clipped(const Polygon& polygon, const glm::dvec4& plane) {
    Polygon kept;
    for (std::size_t i = 0; i < polygon.count; ++i) {
        const glm::dvec4& a = polygon.corners[i];
        const glm::dvec4& b = polygon.corners[(i + 1) % polygon.count];
        const double da = glm::dot(plane, a), db = glm::dot(plane, b);
        if (da >= 0.0) kept.corners[kept.count++] = a;
        // Opposite signs: the divisor is not 0.
        if ((da > 0.0 && db < 0.0) || (da < 0.0 && db > 0.0)) {
            kept.corners[kept.count++] = a + (b - a) * (da / (da - db));
        }
    }
    return kept;
}

// For a box that crosses the plane of the eye, such as a floor below it: its sides are clipped at
// the near plane and at the edges of the picture. A line of sight that enters the box leaves it
// through one of its sides.
ScreenBox clippedScreenBox(const std::array<glm::dvec4, 8>& corners) {
    // Corners in order around each side; the bits of an index are x, y, z.
    constexpr std::array<std::array<std::size_t, 4>, 6> kSides{
        {{0, 2, 6, 4}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 5, 7, 6}}};
    // The near plane, w >= z, comes first: after it w is positive.
    constexpr std::array<glm::dvec4, 5> kPlanes{glm::dvec4(0, 0, -1, 1), glm::dvec4(1, 0, 0, 1),
                                                glm::dvec4(-1, 0, 0, 1), glm::dvec4(0, 1, 0, 1),
                                                glm::dvec4(0, -1, 0, 1)};
    ScreenBox covered;
    for (const std::array<std::size_t, 4>& side : kSides) {
        Polygon polygon;
        for (const std::size_t i : side) polygon.corners[polygon.count++] = corners[i];
        for (const glm::dvec4& plane : kPlanes) polygon = clipped(polygon, plane);
        for (std::size_t i = 0; i < polygon.count; ++i) {
            if (polygon.corners[i].w > 0.0) addCorner(covered, polygon.corners[i]);
        }
    }
    // Rounding moves corners that were clipped at an edge of the picture off that edge.
    constexpr double kRounding = 1e-9;
    const auto snapped = [](double v) {
        return 1.0 - std::abs(v) < kRounding ? std::copysign(1.0, v) : v;
    };
    covered.low = {snapped(covered.low.x), snapped(covered.low.y)};
    covered.high = {snapped(covered.high.x), snapped(covered.high.y)};
    return covered;
}

}  // namespace

Frustum frustumOf(const View& view) {
    const glm::dmat4 m = clipFromEye(view);
    const glm::dvec4 x = row(m, 0), y = row(m, 1), z = row(m, 2), w = row(m, 3);
    return {{w + x, w - x, w + y, w - y, w - z, z}};
}

bool outside(const Frustum& frustum, const Bounds& box) {
    if (box.empty()) return true;
    const glm::dvec3 center = box.center(), half = 0.5 * glm::dvec3(box.extent());
    return std::any_of(frustum.planes.begin(), frustum.planes.end(), [&](const glm::dvec4& p) {
        const glm::dvec3 n(p);
        const double reach = glm::dot(glm::abs(n), half);
        const double slack = 1e-6 * (reach + std::abs(glm::dot(n, center)));  // boxes are float
        return glm::dot(n, center) + p.w < -reach - slack;
    });
}

bool clippedAway(const View& view, const Bounds& box) {
    if (!view.clipPlane || box.empty()) return false;
    const glm::dvec3 n(*view.clipPlane), center = box.center();
    const double reach = glm::dot(glm::abs(n), 0.5 * glm::dvec3(box.extent()));
    const double middle = glm::dot(n, center);
    const double slack = 1e-6 * (reach + std::abs(middle));  // boxes are float
    return middle + reach + view.clipPlane->w <= slack;
}

ScreenBox screenBox(const View& view, const Bounds& box) {
    ScreenBox covered;
    if (box.empty()) return covered;
    const glm::dmat4 m = clipFromEye(view);
    std::array<glm::dvec4, 8> corners;
    for (unsigned i = 0; i < 8; ++i) {
        corners[i] = m * glm::dvec4(i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y,
                                    i & 4 ? box.max.z : box.min.z, 1.0);
    }
    const auto inFront = [](const glm::dvec4& corner) { return corner.w > 0.0; };
    if (!std::all_of(corners.begin(), corners.end(), inFront)) return clippedScreenBox(corners);
    for (const glm::dvec4& corner : corners) addCorner(covered, corner);
    covered.low = glm::clamp(covered.low, -1.0, 1.0);
    covered.high = glm::clamp(covered.high, -1.0, 1.0);
    return covered;
}

double distanceTo(const Bounds& box) {
    return glm::length(glm::clamp(glm::dvec3(0.0), glm::dvec3(box.min), glm::dvec3(box.max)));
}

glm::dmat4 eyeFromLocal(const View& view, const glm::dmat4& worldFromLocal) {
    glm::dmat4 m = worldFromLocal;
    m[3] -= glm::dvec4(view.eye, 0.0);
    return m;
}

}  // namespace clerestory
