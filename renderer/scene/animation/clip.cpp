// Between two keys: glTF 2.0, appendix C.
#include "scene/animation/clip.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace clerestory {
namespace {

constexpr double kThinnest = 1e-6;

std::size_t fixedComponents(AnimatedProperty moved) {
    return moved == AnimatedProperty::rotation ? 4 : 3;
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

// Along the shorter arc, at an even pace.
void slerp(const float* from, const float* to, double share, std::span<double> out) {
    const auto quaternion = [](const float* v) { return unit(glm::dquat(v[3], v[0], v[1], v[2])); };
    const glm::dquat q = glm::slerp(quaternion(from), quaternion(to), share);
    const std::array parts{q.x, q.y, q.z, q.w};
    std::copy(parts.begin(), parts.end(), out.begin());
    normalise(out);
}

}  // namespace

glm::dmat4 matrixOf(const Transform& t) {
    const double longest =
        std::max({std::abs(t.scale.x), std::abs(t.scale.y), std::abs(t.scale.z)});
    const double least = longest > 0.0 ? kThinnest * longest : kThinnest;
    glm::dmat4 matrix = glm::mat4_cast(t.rotation);
    for (int axis = 0; axis < 3; ++axis) {
        const double s = t.scale[axis];
        matrix[axis] *= std::copysign(std::max(std::abs(s), least), s);
    }
    matrix[3] = glm::dvec4(t.translation, 1.0);
    return matrix;
}

std::size_t Track::components() const {
    const std::size_t parts = between == Interpolation::cubicSpline ? 3 : 1;
    return times.empty() ? 0 : values.size() / (parts * times.size());
}

double localTime(const Clip& clip, double time) {
    if (!(clip.duration > 0.0) || !(time > 0.0)) return 0.0;
    return time <= clip.duration ? time : std::fmod(time, clip.duration);
}

void sample(const Track& track, double time, std::span<double> out) {
    const std::vector<float>& times = track.times;
    const std::size_t n = track.components();
    const bool cubic = track.between == Interpolation::cubicSpline;
    const bool turns = track.moved == AnimatedProperty::rotation;
    const std::size_t stride = cubic ? 3 * n : n;
    // Of key k: part 0 is the tangent that comes in, 1 the value, 2 the tangent that goes out.
    const auto part = [&](std::size_t k, std::size_t which) {
        return track.values.data() + k * stride + (cubic ? which * n : 0);
    };
    const auto after = std::upper_bound(times.begin(), times.end(), time,
                                        [](double t, float key) { return t < double{key}; });
    const auto next = static_cast<std::size_t>(after - times.begin());
    const std::size_t k = next > 0 ? next - 1 : 0;
    const bool between = next > 0 && next < times.size();
    if (!between || track.between == Interpolation::step) {
        std::copy(part(k, 1), part(k, 1) + n, out.begin());
        if (turns) normalise(out);
        return;
    }
    // The first key after `time` is later than the last one that is not: the span is not 0.
    const double span = double{times[k + 1]} - double{times[k]};
    const double s = (time - double{times[k]}) / span;
    if (!cubic && turns) return slerp(part(k, 1), part(k + 1, 1), s, out);
    for (std::size_t i = 0; i < n; ++i) {
        const double a = part(k, 1)[i], b = part(k + 1, 1)[i];
        if (!cubic) {
            out[i] = a + (b - a) * s;
            continue;
        }
        const double leaving = span * part(k, 2)[i], coming = span * part(k + 1, 0)[i];
        const double s2 = s * s, s3 = s2 * s;  // Hermite
        out[i] = (2.0 * s3 - 3.0 * s2 + 1.0) * a + (s3 - 2.0 * s2 + s) * leaving +
                 (3.0 * s2 - 2.0 * s3) * b + (s3 - s2) * coming;
    }
    if (turns) normalise(out);
}

bool sound(const Track& track, std::size_t targets) {
    const auto held = [](float v) { return std::abs(v) <= kMaxKey; };  // false for a NaN
    const std::size_t parts = track.between == Interpolation::cubicSpline ? 3 : 1;
    const std::size_t keys = track.times.size(), n = track.components();
    return track.target < targets && keys > 0 && n > 0 && track.values.size() == keys * parts * n &&
           (track.moved == AnimatedProperty::weights || n == fixedComponents(track.moved)) &&
           std::all_of(track.values.begin(), track.values.end(), held) &&
           std::all_of(track.times.begin(), track.times.end(),
                       [&](float t) { return held(t) && t >= 0.0f; }) &&
           std::is_sorted(track.times.begin(), track.times.end());
}

}  // namespace clerestory
