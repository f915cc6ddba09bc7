#include "plan/visibility/mirror.h"

#include "plan/visibility/view.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace clerestory {

glm::dmat4 householder(const Plane& plane) {
    const glm::dvec3& n = plane.normal;
    glm::dmat4 m(glm::dmat3(1.0) - 2.0 * glm::outerProduct(n, n));
    m[3] = glm::dvec4(-2.0 * plane.offset * n, 1.0);
    return m;
}

double eyeHeight(const Plane& plane, const View& view) {
    if (!view.orthographic) return plane.distance(view.eye);
    const glm::dvec3 back(glm::transpose(glm::dmat3(view.viewFromWorld))[2]);
    const double facing = glm::dot(plane.normal, back);
    return facing > 1e-9 ? 1.0 : facing < -1e-9 ? -1.0 : 0.0;
}

bool edgeOn(double eyeHeight, const View& view, std::uint32_t pictureHeight) {
    if (view.orthographic) return eyeHeight == 0.0;
    // Slope of one pixel; nothing nearer than znear is visible.
    const double pixel = 2.0 / (pictureHeight * std::abs(view.clipFromView[1][1]));
    return eyeHeight < view.znear * pixel;
}

View mirroredView(const View& view, const Plane& plane) {
    View mirrored = view;
    const glm::dvec3& n = plane.normal;
    const double height = plane.distance(view.eye);
    mirrored.viewFromWorld = view.viewFromWorld * householder(plane);
    mirrored.eye = view.eye - 2.0 * height * n;
    mirrored.mirrored = !view.mirrored;
    // Relative to the mirrored eye, which is `height` behind the plane.
    mirrored.clipPlane = glm::dvec4(n, -height);
    return mirrored;
}

PixelRect pixelRect(const ScreenBox& box, std::uint32_t width, std::uint32_t height, double guard) {
    const glm::dvec2 size(width, height);
    const glm::dvec2 low = glm::floor((0.5 * box.low + 0.5) * size - guard);
    const glm::dvec2 high = glm::ceil((0.5 * box.high + 0.5) * size + guard);
    return {low.x, low.y, std::max(1.0, high.x - low.x), std::max(1.0, high.y - low.y)};
}

TargetRect touchedPixels(const ScreenBox& box, std::uint32_t width, std::uint32_t height,
                         double guard) {
    if (box.empty()) return {0, 0, 1, 1};
    const PixelRect touched = pixelRect(box, width, height, guard);
    const auto clamped = [](double x, std::uint32_t low, std::uint32_t high) {
        return static_cast<std::uint32_t>(std::clamp(x, double(low), double(high)));
    };
    const std::uint32_t x = clamped(touched.x, 0, width - 1);
    const std::uint32_t y = clamped(touched.y, 0, height - 1);
    return {x, y, clamped(touched.x + touched.width, x + 1, width) - x,
            clamped(touched.y + touched.height, y + 1, height) - y};
}

PixelRect alignedToGrid(const PixelRect& rect, double edge) {
    const glm::dvec2 low = edge * glm::floor(glm::dvec2(rect.x, rect.y) / edge);
    const glm::dvec2 high =
        edge * glm::ceil(glm::dvec2(rect.x + rect.width, rect.y + rect.height) / edge);
    return {low.x, low.y, high.x - low.x, high.y - low.y};
}

View cropped(const View& view, const PixelRect& part, std::uint32_t width, std::uint32_t height) {
    // Clip x, y of the part: scale * (x, y) + offset * w.
    const glm::dvec2 size(width, height), extent(part.width, part.height);
    const glm::dvec2 center = 2.0 * (glm::dvec2(part.x, part.y) + 0.5 * extent) / size - 1.0;
    const glm::dvec2 scale = size / extent;
    glm::dmat4 partFromClip(1.0);
    partFromClip[0][0] = scale.x;
    partFromClip[1][1] = scale.y;
    partFromClip[3][0] = -scale.x * center.x;
    partFromClip[3][1] = -scale.y * center.y;
    View result = view;
    result.clipFromView = partFromClip * view.clipFromView;
    return result;
}

std::array<View, 6> cubeFaceViews(const glm::dvec3& center, double znear,
                                  const glm::dmat3& worldFromCube) {
    // Outward normal of each face, and the directions of increasing s and t.
    static const glm::dvec3 axes[6][3] = {
        {{1, 0, 0}, {0, 0, -1}, {0, -1, 0}}, {{-1, 0, 0}, {0, 0, 1}, {0, -1, 0}},
        {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},   {{0, -1, 0}, {1, 0, 0}, {0, 0, -1}},
        {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}},  {{0, 0, -1}, {-1, 0, 0}, {0, -1, 0}},
    };
    std::array<View, 6> views;
    for (std::size_t face = 0; face < 6; ++face) {
        const auto& [normal, s, t] = axes[face];
        const glm::dmat3 worldFromView = worldFromCube * glm::dmat3(s, t, -normal);
        View& view = views[face];
        view.viewFromWorld = glm::dmat4(glm::transpose(worldFromView));
        view.viewFromWorld[3] = glm::dvec4(-(glm::transpose(worldFromView) * center), 1.0);
        // Not from tan(): the focal length must be exactly 1, or seams appear (erratum C5).
        glm::dmat4 clip(0.0);
        clip[0][0] = clip[1][1] = 1.0;
        clip[2][3] = -1.0;
        clip[3][2] = znear;
        view.clipFromView = clip;
        view.eye = center;
        view.znear = znear;
    }
    return views;
}

}  // namespace clerestory
