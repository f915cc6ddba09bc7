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

// The near plane, w >= z, comes first: after it w is positive. Then the edges of the picture.
constexpr std::array<glm::dvec4, 5> kEdges{glm::dvec4(0, 0, -1, 1), glm::dvec4(1, 0, 0, 1),
                                           glm::dvec4(-1, 0, 0, 1), glm::dvec4(0, 1, 0, 1),
                                           glm::dvec4(0, -1, 0, 1)};

// For a box that crosses the plane of the eye, such as a floor below it: its sides are clipped at
// the near plane and at the edges of the picture. A line of sight that enters the box leaves it
// through one of its sides.
ScreenBox clippedScreenBox(const std::array<glm::dvec4, 8>& corners) {
    // Corners in order around each side; the bits of an index are x, y, z.
    constexpr std::array<std::array<std::size_t, 4>, 6> kSides{
        {{0, 2, 6, 4}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 5, 7, 6}}};
    ScreenBox covered;
    for (const std::array<std::size_t, 4>& side : kSides) {
        Polygon polygon;
        for (const std::size_t i : side) polygon.corners[polygon.count++] = corners[i];
        for (const glm::dvec4& plane : kEdges) polygon = clipped(polygon, plane);
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

// The part of the plane inside the box.
Polygon section(const Bounds& box, const Plane& plane) {
    const glm::dvec3 center(box.center()), half = 0.5 * glm::dvec3(box.extent());
    const glm::dvec3 n = plane.normal;
    const glm::dvec3 other = std::abs(n.x) < 0.7 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const double reach = 2.0 * glm::length(half);
    const glm::dvec3 u = reach * glm::normalize(glm::cross(n, other)), v = glm::cross(n, u);
    const glm::dvec3 middle = center - plane.distance(center) * n;
    Polygon polygon{.count = 4};
    polygon.corners = {glm::dvec4(middle - u - v, 1), glm::dvec4(middle + u - v, 1),
                       glm::dvec4(middle + u + v, 1), glm::dvec4(middle - u + v, 1)};
    for (int axis = 0; axis < 3; ++axis) {
        for (const double side : {-1.0, 1.0}) {
            glm::dvec4 inside(0.0);
            inside[axis] = side;
            const double slack = 1e-6 * (reach + std::abs(center[axis]));  // boxes are float
            inside.w = half[axis] + slack - side * center[axis];
            polygon = clipped(polygon, inside);
        }
    }
    return polygon;
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

FlatExtent flatExtent(const View& view, const Bounds& box, const Plane& plane) {
    FlatExtent extent;
    if (box.empty()) return extent;
    Polygon polygon = section(box, plane);
    const auto corner = [&](std::size_t i) { return glm::dvec3(polygon.corners[i]); };
    glm::dvec3 area(0.0);
    for (std::size_t i = 2; i < polygon.count; ++i) {
        area += glm::cross(corner(i - 1) - corner(0), corner(i) - corner(0));
    }
    extent.area = 0.5 * glm::length(area);
    const glm::dmat4 m = clipFromEye(view);
    for (std::size_t i = 0; i < polygon.count; ++i) polygon.corners[i] = m * polygon.corners[i];
    for (const glm::dvec4& edge : kEdges) polygon = clipped(polygon, edge);
    const auto seen = [&](std::size_t i) {
        return glm::dvec2(polygon.corners[i]) / std::max(polygon.corners[i].w, 1e-300);
    };
    double doubled = 0.0;  // of a picture whose area is 4
    for (std::size_t i = 2; i < polygon.count; ++i) {
        const glm::dvec2 a = seen(i - 1) - seen(0), b = seen(i) - seen(0);
        doubled += a.x * b.y - a.y * b.x;
    }
    extent.share = std::min(0.125 * std::abs(doubled), 1.0);
    return extent;
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
