// Interpolation: glTF 2.0, appendix C.
#include "scene/animation/clip.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace clerestory {
namespace {

constexpr double kMinScale = 1e-6;

std::size_t fixedComponents(AnimatedProperty property) {
    return property == AnimatedProperty::rotation ? 4 : 3;
}

glm::dquat unit(const glm::dquat& q) {
    const double length = glm::length(q);
    return length > 1e-12 ? q / length : glm::dquat(1.0, 0.0, 0.0, 0.0);
}

void normalise(std::span<double> xyzw) {
    const glm::dquat q = unit(glm::dquat(xyzw[3], xyzw[0], xyzw[1], xyzw[2]));
    const std::array parts{q.x, q.y, q.z, q.w};
    std::copy(parts.begin(), parts.end(), xyzw.begin());
}

// Along the shorter arc.
void slerp(const float* from, const float* to, double t, std::span<double> out) {
    const auto quaternion = [](const float* v) { return unit(glm::dquat(v[3], v[0], v[1], v[2])); };
    const glm::dquat q = glm::slerp(quaternion(from), quaternion(to), t);
    const std::array parts{q.x, q.y, q.z, q.w};
    std::copy(parts.begin(), parts.end(), out.begin());
    normalise(out);
}

}  // namespace

glm::dmat4 matrixOf(const Transform& t) {
    const double longest =
        std::max({std::abs(t.scale.x), std::abs(t.scale.y), std::abs(t.scale.z)});
    const double minScale = longest > 0.0 ? kMinScale * longest : kMinScale;
    glm::dmat4 matrix = glm::mat4_cast(t.rotation);
    for (int axis = 0; axis < 3; ++axis) {
        const double s = t.scale[axis];
        matrix[axis] *= std::copysign(std::max(std::abs(s), minScale), s);
    }
    matrix[3] = glm::dvec4(t.translation, 1.0);
    return matrix;
}

std::size_t Track::components() const {
    const std::size_t parts = interpolation == Interpolation::cubicSpline ? 3 : 1;
    return times.empty() ? 0 : values.size() / (parts * times.size());
}

double localTime(const Clip& clip, double time) {
    if (!(clip.duration > 0.0) || !(time > 0.0)) return 0.0;
    return time <= clip.duration ? time : std::fmod(time, clip.duration);
}

void sample(const Track& track, double time, std::span<double> out) {
    const std::vector<float>& times = track.times;
    const std::size_t n = track.components();
    const bool cubic = track.interpolation == Interpolation::cubicSpline;
    const bool isRotation = track.property == AnimatedProperty::rotation;
    const std::size_t stride = cubic ? 3 * n : n;
    // Of key k: part 0 is the in-tangent, 1 the value, 2 the out-tangent.
    const auto part = [&](std::size_t k, std::size_t which) {
        return track.values.data() + k * stride + (cubic ? which * n : 0);
    };
    const auto after = std::upper_bound(times.begin(), times.end(), time,
                                        [](double t, float key) { return t < double{key}; });
    const auto next = static_cast<std::size_t>(after - times.begin());
    const std::size_t k = next > 0 ? next - 1 : 0;
    const bool betweenKeys = next > 0 && next < times.size();
    if (!betweenKeys || track.interpolation == Interpolation::step) {
        std::copy(part(k, 1), part(k, 1) + n, out.begin());
        if (isRotation) normalise(out);
        return;
    }
    // Key k + 1 is after `time` and key k is not: the span is not 0.
    const double span = double{times[k + 1]} - double{times[k]};
    const double s = (time - double{times[k]}) / span;
    if (!cubic && isRotation) return slerp(part(k, 1), part(k + 1, 1), s, out);
    for (std::size_t i = 0; i < n; ++i) {
        const double a = part(k, 1)[i], b = part(k + 1, 1)[i];
        if (!cubic) {
            out[i] = a + (b - a) * s;
            continue;
        }
        const double outTangent = span * part(k, 2)[i], inTangent = span * part(k + 1, 0)[i];
        const double s2 = s * s, s3 = s2 * s;  // Hermite
        out[i] = (2.0 * s3 - 3.0 * s2 + 1.0) * a + (s3 - 2.0 * s2 + s) * outTangent +
                 (3.0 * s2 - 2.0 * s3) * b + (s3 - s2) * inTangent;
    }
    if (isRotation) normalise(out);
}

bool isValid(const Track& track, std::size_t targets) {
    const auto inRange = [](float v) { return std::abs(v) <= kMaxKey; };  // false for a NaN
    const std::size_t parts = track.interpolation == Interpolation::cubicSpline ? 3 : 1;
    const std::size_t keys = track.times.size(), n = track.components();
    return track.target < targets && keys > 0 && n > 0 && track.values.size() == keys * parts * n &&
           (track.property == AnimatedProperty::weights || n == fixedComponents(track.property)) &&
           std::all_of(track.values.begin(), track.values.end(), inRange) &&
           std::all_of(track.times.begin(), track.times.end(),
                       [&](float t) { return inRange(t) && t >= 0.0f; }) &&
           std::is_sorted(track.times.begin(), track.times.end());
}

}  // namespace clerestory
