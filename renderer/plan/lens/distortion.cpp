#include "plan/lens/distortion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace clerestory {
namespace {

constexpr double kPi = std::numbers::pi;

// Symmetric.
struct Jacobian {
    double xx, xy, yy;
};

Jacobian jacobianOf(const PerspectiveLens& l, const glm::dvec2& t) {
    const double r2 = glm::dot(t, t);
    const double radial = 1.0 + r2 * (l.k1 + r2 * (l.k2 + r2 * l.k3));
    const double slope = 2.0 * (l.k1 + r2 * (2.0 * l.k2 + r2 * 3.0 * l.k3));  // per r^2, twice
    return {radial + slope * t.x * t.x + 2.0 * l.p1 * t.y + 6.0 * l.p2 * t.x,
            slope * t.x * t.y + 2.0 * l.p1 * t.x + 2.0 * l.p2 * t.y,
            radial + slope * t.y * t.y + 6.0 * l.p1 * t.y + 2.0 * l.p2 * t.x};
}

double leastEigenvalue(const Jacobian& j) {
    const double mean = 0.5 * (j.xx + j.yy);
    return mean - std::hypot(0.5 * (j.xx - j.yy), j.xy);
}

// Below it a pixel would show more than a thousand times what its neighbours show.
constexpr double kLeastStretch = 1e-3;

bool increasesAt(const PerspectiveLens& lens, double radius) {
    const bool round = lens.p1 == 0.0 && lens.p2 == 0.0;
    const int directions = round ? 1 : 32;
    for (int i = 0; i < directions; ++i) {
        const double angle = 2.0 * kPi * i / directions;
        const glm::dvec2 at = radius * glm::dvec2(std::cos(angle), std::sin(angle));
        if (!(leastEigenvalue(jacobianOf(lens, at)) > kLeastStretch)) return false;
    }
    return true;
}

// The last value of [low, high] for which `holds`, which is true at `low`.
template <class Holds>
double lastOf(double low, double high, const Holds& holds) {
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (holds(middle) ? low : high) = middle;
    }
    return low;
}

double slopeOfAngle(const FisheyeLens& l, double theta) {
    const double t2 = theta * theta;
    return 1.0 + t2 * (3.0 * l.k1 + t2 * (5.0 * l.k2 + t2 * (7.0 * l.k3 + t2 * 9.0 * l.k4)));
}

}  // namespace

glm::dvec2 distorted(const PerspectiveLens& l, const glm::dvec2& t) {
    const double r2 = glm::dot(t, t);
    const double radial = 1.0 + r2 * (l.k1 + r2 * (l.k2 + r2 * l.k3));
    return {t.x * radial + 2.0 * l.p1 * t.x * t.y + l.p2 * (r2 + 2.0 * t.x * t.x),
            t.y * radial + l.p1 * (r2 + 2.0 * t.y * t.y) + 2.0 * l.p2 * t.x * t.y};
}

double injectiveRadius(const PerspectiveLens& lens) {
    const auto increases = [&](double radius) { return increasesAt(lens, radius); };
    constexpr double kStep = 1.03;
    double last = 0.0;
    for (double radius = 1e-4; radius <= kMaxTangent; radius *= kStep) {
        if (!increases(radius)) return lastOf(last, radius, increases);
        last = radius;
    }
    return last;
}

std::optional<glm::dvec2> undistorted(const PerspectiveLens& lens, const glm::dvec2& at,
                                      double radius) {
    glm::dvec2 t(0.0), missing = at;
    const double scale = std::max(1.0, glm::length(at));
    constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
    for (int i = 0; i < 100; ++i) {
        const double error = glm::length(missing);
        if (error <= 2.0 * kEpsilon * scale) return t;
        const Jacobian j = jacobianOf(lens, t);
        const double determinant = j.xx * j.yy - j.xy * j.xy;
        if (!(determinant > 0.0)) return std::nullopt;
        glm::dvec2 step =
            glm::dvec2(j.yy * missing.x - j.xy * missing.y, j.xx * missing.y - j.xy * missing.x) /
            determinant;
        // A step that leaves the disc or comes no nearer is halved.
        bool nearer = false;
        for (int halvings = 0; halvings < 50 && !nearer; ++halvings, step *= 0.5) {
            const glm::dvec2 next = t + step;
            if (glm::length(next) > radius) continue;
            const glm::dvec2 left = at - distorted(lens, next);
            if (!(glm::length(left) < error)) continue;
            t = next;
            missing = left;
            nearer = true;
        }
        // At the precision of the numbers no step comes nearer.
        if (!nearer) return error <= 64.0 * kEpsilon * scale ? std::optional(t) : std::nullopt;
    }
    return std::nullopt;
}

double distortedAngle(const FisheyeLens& l, double theta) {
    const double t2 = theta * theta;
    return theta * (1.0 + t2 * (l.k1 + t2 * (l.k2 + t2 * (l.k3 + t2 * l.k4))));
}

double injectiveAngle(const FisheyeLens& lens) {
    const auto increases = [&](double theta) { return slopeOfAngle(lens, theta) > kLeastStretch; };
    constexpr int kSteps = 2048;
    for (int i = 1; i <= kSteps; ++i) {
        const double theta = kPi * i / kSteps;
        if (!increases(theta)) return lastOf(kPi * (i - 1) / kSteps, theta, increases);
    }
    return kPi;
}

double undistortedAngle(const FisheyeLens& lens, double value, double most) {
    double low = 0.0, high = most, theta = std::min(value, most);
    for (int i = 0; i < 100; ++i) {
        const double missing = value - distortedAngle(lens, theta);
        if (missing == 0.0) return theta;
        (missing > 0.0 ? low : high) = theta;
        double next = theta + missing / slopeOfAngle(lens, theta);
        if (!(next >= low && next <= high)) next = 0.5 * (low + high);
        if (next == theta) return theta;
        theta = next;
    }
    return theta;
}

}  // namespace clerestory
