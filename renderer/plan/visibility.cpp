// Conservative visibility tests.
#include "plan/visibility.h"

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

ScreenBox screenBox(const View& view, const Bounds& box) {
    ScreenBox covered;
    if (box.empty()) return covered;
    const glm::dmat4 m = clipFromEye(view);
    for (int i = 0; i < 8; ++i) {
        const glm::dvec4 corner(i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y,
                                i & 4 ? box.max.z : box.min.z, 1.0);
        const glm::dvec4 clip = m * corner;
        if (!(clip.w > 0.0)) return {glm::dvec2(-1.0), glm::dvec2(1.0)};
        const glm::dvec2 ndc = glm::dvec2(clip) / clip.w;
        covered.low = glm::min(covered.low, ndc);
        covered.high = glm::max(covered.high, ndc);
    }
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
