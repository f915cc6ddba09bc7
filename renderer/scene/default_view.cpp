#include "scene/default_view.h"

#include "scene/fit.h"

#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <limits>
#include <vector>

namespace clerestory {
namespace {

constexpr double kFittedYfov = 0.7;  // in frames of the following shape
constexpr double kFittedAspect = 4.0 / 3.0;
// A camera with a smaller covered share is treated as one that sees no surface.
constexpr double kLeastCovered = 0.004;
// Of the corners in the frame of a camera that looks at the scene from outside: with less it shows
// a detail, as the default camera of an exporter does.
constexpr double kLeastShown = 0.25;
constexpr int kSamples = 32;  // along each side of the frame

// The view of a camera: its position, and the point on its axis closest to the scene's centre.
std::optional<DefaultView> viewThrough(const Camera& camera, const Pose& pose,
                                       const Bounds& bounds) {
    const glm::dmat4& m = pose.worldFromNode[camera.node];
    const glm::dvec3 eye(m[3]), back(m[2]);
    if (camera.orthographic || !(glm::length(back) > 0.0)) return std::nullopt;
    const glm::dvec3 forward = -glm::normalize(back);
    const double middle =
        bounds.empty() ? 1.0 : glm::dot(glm::dvec3(bounds.center()) - eye, forward);
    const double minDistance =
        bounds.empty() ? 1.0 : 0.01 * std::max(1e-6, double{bounds.diagonal()});
    return DefaultView{eye, eye + std::max(middle, minDistance) * forward, camera.yfov};
}

// At time 0 and at other times of the default clips.
std::vector<glm::dvec3> lastingCorners(const Scene& scene, std::size_t most) {
    constexpr int kTimes = 8;
    double duration = 0.0;
    for (const Index clip : defaultClips(scene)) {
        duration = std::max(duration, scene.clips[clip].duration);
    }
    const int times = duration > 0.0 ? kTimes : 1;
    std::vector<glm::dvec3> corners;
    for (int i = 0; i < times; ++i) {
        const Pose pose = poseAt(scene, duration * i / times);
        const auto now = cornersOf(scene, pose, {}, most / static_cast<std::size_t>(times));
        corners.insert(corners.end(), now.begin(), now.end());
    }
    return corners;
}

// Few corners, far outside of the box of the others.
struct Stray {
    double share;      // of the corners at each end of an axis, at most
    double diagonals;  // of that box
};
constexpr std::array kStray{Stray{0.002, 1.0}, Stray{0.05, 8.0}};

void removeStray(std::vector<glm::dvec3>& corners) {
    for (const Stray& stray : kStray) {
        const auto skip =
            static_cast<std::ptrdiff_t>(stray.share * static_cast<double>(corners.size()));
        if (skip == 0) continue;
        glm::dvec3 low, high;
        std::vector<double> along(corners.size());
        for (int axis = 0; axis < 3; ++axis) {
            std::transform(corners.begin(), corners.end(), along.begin(),
                           [&](const glm::dvec3& p) { return p[axis]; });
            const auto first = along.begin() + skip, last = along.end() - 1 - skip;
            std::nth_element(along.begin(), first, along.end());
            low[axis] = *first;
            std::nth_element(along.begin(), last, along.end());
            high[axis] = *last;
        }
        const glm::dvec3 margin(stray.diagonals * glm::length(high - low));
        if (!(margin.x > 0.0)) continue;
        std::erase_if(corners, [&](const glm::dvec3& p) {
            return glm::any(glm::lessThan(p, low - margin)) ||
                   glm::any(glm::greaterThan(p, high + margin));
        });
    }
}

// Which samples of a square frame a triangle covers: a sample's ray lies inside the three planes
// through the eye and an edge, and meets the triangle's plane in front of the eye. Lines and points
// cover the nearest samples.
class Coverage {
public:
    explicit Coverage(double yfov) : extent_(std::tan(0.5 * yfov)) {}

    // Corners in camera space: right, up, back.
    void add(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
        if (b == c) return addLine(a, b);
        const std::array<glm::dvec3, 3> corners{a, b, c};
        int first[2] = {0, 0}, last[2] = {kSamples - 1, kSamples - 1};
        if (std::all_of(corners.begin(), corners.end(),
                        [](const glm::dvec3& p) { return p.z < 0.0; })) {
            for (int axis = 0; axis < 2; ++axis) {
                double low = 1e9, high = -1e9;
                for (const glm::dvec3& p : corners) {
                    low = std::min(low, p[axis] / -p.z);
                    high = std::max(high, p[axis] / -p.z);
                }
                first[axis] = static_cast<int>(std::ceil(std::clamp(sample(low), 0.0, 1e3)));
                last[axis] =
                    static_cast<int>(std::floor(std::clamp(sample(high), -1.0, kSamples - 1.0)));
            }
        } else if (a.z >= 0.0 && b.z >= 0.0 && c.z >= 0.0) {
            return;
        }
        const glm::dvec3 ab = glm::cross(a, b), bc = glm::cross(b, c), ca = glm::cross(c, a);
        const double volume = glm::dot(a, bc);
        if (volume == 0.0) return;
        const double side = volume > 0.0 ? 1.0 : -1.0;
        for (int y = first[1]; y <= last[1]; ++y) {
            for (int x = first[0]; x <= last[0]; ++x) {
                const glm::dvec3 ray(tangent(x), tangent(y), -1.0);
                if (side * glm::dot(ray, ab) >= 0.0 && side * glm::dot(ray, bc) >= 0.0 &&
                    side * glm::dot(ray, ca) >= 0.0) {
                    covered_.set(static_cast<std::size_t>(y * kSamples + x));
                }
            }
        }
    }

    double share() const {
        return static_cast<double>(covered_.count()) / static_cast<double>(covered_.size());
    }

private:
    void addLine(const glm::dvec3& from, const glm::dvec3& to) {
        const int steps = from == to ? 0 : kSamples;
        for (int i = 0; i <= steps; ++i) {
            const glm::dvec3 p = from + (to - from) * (i / std::max(1.0, double(steps)));
            if (!(p.z < 0.0)) continue;
            const glm::dvec2 at(std::round(sample(p.x / -p.z)), std::round(sample(p.y / -p.z)));
            if (at.x >= 0.0 && at.x < kSamples && at.y >= 0.0 && at.y < kSamples) {
                covered_.set(static_cast<std::size_t>(at.y * kSamples + at.x));
            }
        }
    }

    double tangent(int i) const { return extent_ * ((2.0 * i + 1.0) / kSamples - 1.0); }
    double sample(double tangent) const { return 0.5 * kSamples * (tangent / extent_ + 1.0) - 0.5; }

    double extent_;
    std::bitset<kSamples * kSamples> covered_;
};

}  // namespace

namespace {

// Right, up and back of the view's eye.
std::vector<glm::dvec3> cornersInView(const Scene& scene, const Pose& pose,
                                      const DefaultView& view) {
    const ViewAxes axes = uprightAxes(glm::normalize(view.position - view.target));
    std::vector<glm::dvec3> corners = cornersOf(scene, pose);
    for (glm::dvec3& p : corners) {
        const glm::dvec3 v = p - view.position;
        p = {glm::dot(v, axes.right), glm::dot(v, axes.up), glm::dot(v, axes.back)};
    }
    return corners;
}

double coveredShare(const std::vector<glm::dvec3>& cornersInView, double yfov) {
    Coverage coverage(yfov);
    for (std::size_t i = 0; i < cornersInView.size(); i += 3) {
        coverage.add(cornersInView[i], cornersInView[i + 1], cornersInView[i + 2]);
    }
    return coverage.share();
}

// The share of corners that a frame of kFittedAspect has.
double shownShare(const std::vector<glm::dvec3>& cornersInView, double yfov) {
    const double y = std::tan(0.5 * yfov), x = kFittedAspect * y;
    const auto shown =
        std::count_if(cornersInView.begin(), cornersInView.end(), [&](const glm::dvec3& p) {
            return p.z < 0.0 && std::abs(p.x) <= -x * p.z && std::abs(p.y) <= -y * p.z;
        });
    return static_cast<double>(shown) /
           static_cast<double>(std::max<std::size_t>(cornersInView.size(), 1));
}

// Whether the camera was placed for this scene: it sees a surface, and from outside not a detail.
bool isPlaced(const Scene& scene, const Pose& pose, const Bounds& bounds, const DefaultView& view) {
    const std::vector<glm::dvec3> corners = cornersInView(scene, pose, view);
    const bool inside = glm::all(glm::greaterThanEqual(view.position, glm::dvec3(bounds.min))) &&
                        glm::all(glm::lessThanEqual(view.position, glm::dvec3(bounds.max)));
    return coveredShare(corners, view.yfov) >= kLeastCovered &&
           (inside || shownShare(corners, view.yfov) >= kLeastShown);
}

}  // namespace

double coveredShare(const Scene& scene, const Pose& pose, const DefaultView& view) {
    return coveredShare(cornersInView(scene, pose, view), view.yfov);
}

DefaultView fittedView(const Scene& scene, std::size_t most) {
    std::vector<glm::dvec3> corners = lastingCorners(scene, most);
    if (corners.empty()) return {};
    removeStray(corners);
    const ViewAxes axes = uprightAxes(glm::normalize(glm::dvec3(0.5, 0.35, 1.0)));
    const double y = kFittedShare * std::tan(0.5 * kFittedYfov), x = kFittedAspect * y;
    const glm::dvec3 eye = fittedEye(corners, axes, {x, x, y, y});
    DefaultView view{.position = eye};
    double nearest = std::numeric_limits<double>::max(), farthest = 0.0;
    for (const glm::dvec3& corner : corners) {
        const glm::dvec3 p = corner - eye;
        const double depth = -glm::dot(p, axes.back);
        const glm::dvec2 across(glm::dot(p, axes.right), glm::dot(p, axes.up));
        view.fit = glm::max(view.fit, glm::abs(across) / depth);
        nearest = std::min(nearest, depth);
        farthest = std::max(farthest, depth);
    }
    view.target = eye - 0.5 * (nearest + farthest) * axes.back;
    view.fit = glm::clamp(view.fit, 1e-4, 10.0);
    view.yfov = fieldOfView(view, kFittedAspect);
    return view;
}

double fieldOfView(const DefaultView& view, double aspect) {
    if (view.fit == glm::dvec2(0.0)) return view.yfov;
    return 2.0 * std::atan(std::max(view.fit.y, view.fit.x / aspect) / kFittedShare);
}

DefaultView chosenView(const Scene& scene) {
    const Pose pose = poseAt(scene, 0.0);
    const Bounds bounds = lastingBounds(scene, pose);
    for (const Camera& camera : scene.cameras) {
        const auto view = viewThrough(camera, pose, bounds);
        if (view && isPlaced(scene, pose, bounds, *view)) return *view;
    }
    return fittedView(scene);
}

DefaultView defaultView(const Scene& scene) {
    return scene.defaultView ? *scene.defaultView : chosenView(scene);
}

}  // namespace clerestory
