#include "plan/effects/near_shadows.h"

#include "plan/visibility/culling.h"
#include "plan/visibility/view.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace clerestory {
namespace {

// Of the finest texels, in pixels on the nearest surfaces.
double texelsWanted(Preset preset) {
    return preset == Preset::draft ? 8.0 : preset == Preset::fine ? 2.0 : 4.0;
}
// A picture of a part is worth its time if its texels are this much smaller, at least.
constexpr double kLeastGain = 2.0;
// From one picture to the next; beyond it there is another one between them.
constexpr double kLargestStep = 7.0;
// Of the whole to the finest; depth has no more precision.
constexpr double kMaxGain = 512.0;

double extentOf(const View& picture) {
    return 2.0 / std::min(picture.clipFromView[0][0], picture.clipFromView[1][1]);
}

// Distance within which surfaces are that cover a tenth of a view at most, metres; `farthest` if
// none is nearer.
double nearestSurfaces(const Stage& stage, const View& view, double farthest) {
    constexpr double kShare = 0.1;
    // What is about the eye and not flat, relative to its diagonal.
    constexpr double kAbout = 0.1;
    std::vector<std::pair<double, double>> found;  // distance, share of the picture
    Culling culling(stage, view);
    for (const Surface& surface : stage.surfaces) {
        const Instance& instance = stage.scene.instances[surface.instance];
        std::optional<Plane> plane;
        if (surface.flatPart != kNone) {
            plane = transformed(stage.scene.flatParts[surface.flatPart].plane(),
                                stage.pose.worldFromNode[instance.node]);
        }
        culling.eachInView(surface, [&](const Cluster&, const Bounds& box) {
            const double least =
                plane ? std::abs(plane->distance(view.eye)) : kAbout * double(box.diagonal());
            const double distance = std::max(distanceTo(box), least);
            if (distance >= farthest) return;
            found.emplace_back(distance, screenBox(view, box).share());
        });
    }
    std::sort(found.begin(), found.end());
    double covered = 0.0;
    for (const auto& [distance, share] : found) {
        covered += share;
        if (covered >= kShare) return distance;
    }
    return farthest;
}

double powerOfTwoNear(double x) {
    return std::exp2(std::round(std::log2(x)));
}

// Of a square of this extent about a point. It moves in steps of some of its texels, so that the
// same picture serves many views.
View partOf(const View& whole, const glm::dvec3& center, double extent) {
    constexpr double kSteps = 8.0;
    const glm::dvec3 origin = glm::dmat3(whole.viewFromWorld) * whole.eye;
    const glm::dvec3 middle = glm::dmat3(whole.viewFromWorld) * center;
    const double step = extent / kSteps;
    View part = whole;
    for (int axis = 0; axis < 2; ++axis) {
        const double snapped = step * std::round(middle[axis] / step);
        part.clipFromView[axis][axis] = 2.0 / extent;
        part.clipFromView[3][axis] = -2.0 / extent * (snapped - origin[axis]);
    }
    return part;
}

// Of a nearer picture, texels.
std::uint32_t nearEdgeOf(const Shadow& whole) {
    return std::min(whole.edge / 2, 1024u);
}

// Of parts of the picture of a directional light, the finest last.
std::vector<View> nearViews(const Stage& stage, const Shadow& whole, const Observer& observer,
                            Preset preset) {
    const View& sun = whole.views.front();
    const View& eye = observer.views.front();
    if (!sun.orthographic || eye.orthographic) return {};
    // Of a texel, metres.
    const double coarsest = extentOf(sun) / whole.edge;
    const auto wantedAt = [&](double distance) {
        return distance * observer.pixel * texelsWanted(preset);
    };
    const double farthest = coarsest / kLeastGain / wantedAt(1.0);
    const Bounds everything =
        transformed(lastingBounds(stage.scene, stage.pose), eyeFromLocal(eye, glm::dmat4(1.0)));
    if (distanceTo(everything) >= farthest) return {};
    double distance = farthest;
    for (const View& view : observer.views) {
        distance = std::min(distance, nearestSurfaces(stage, view, farthest));
    }
    if (distance >= farthest) return {};
    const double gain = std::min(coarsest / wantedAt(distance), kMaxGain);
    const double steps = std::clamp(std::ceil(std::log(gain) / std::log(kLargestStep)), 1.0,
                                    double(kMaxNearShadows));
    // Most of what a single view shows is before the eye.
    constexpr double kAhead = 0.35;
    const bool ahead = observer.views.size() == 1;
    const glm::dvec3 forward = -glm::transpose(glm::dmat3(eye.viewFromWorld))[2];
    std::vector<View> views;
    for (double i = 1.0; i <= steps; i += 1.0) {
        const double texel = coarsest * std::pow(gain, -i / steps);
        const double extent = powerOfTwoNear(texel * nearEdgeOf(whole));
        const double way = ahead ? distance + kAhead * extent : 0.0;
        views.push_back(partOf(sun, eye.eye + forward * way, extent));
    }
    return views;
}

// Suns that may have nearer pictures: more would take more memory than they are worth.
constexpr std::size_t kMaxNearSuns = 2;

}  // namespace

std::optional<MapSize> placeNearer(const Stage& stage, const std::vector<Shadow>& shadows,
                                   const MapSize& others, const Observer& observer,
                                   std::vector<PlacedLight>& lights) {
    if (observer.views.empty()) return std::nullopt;
    MapSize size = others;
    TargetRect next{others.width, 0, 0, 0};
    bool any = false;
    std::size_t suns = 0;
    for (const Shadow& shadow : shadows) {
        if (!shadow.views.front().orthographic || ++suns > kMaxNearSuns) continue;
        const std::vector<View> views =
            nearViews(stage, shadow, observer, stage.settings.accuracy.preset);
        any |= !views.empty();
        next.width = next.height = nearEdgeOf(shadow);
        for (std::size_t i = 0; i < kMaxNearShadows; ++i) {
            if (next.y > 0 && next.y + next.height > others.height) {
                next.x = size.width;
                next.y = 0;
            }
            if (i < views.size()) lights[shadow.light].shadow->nearer.push_back({next, views[i]});
            size = {std::max(size.width, next.x + next.width),
                    std::max(size.height, next.y + next.height)};
            next.y += next.height;
        }
    }
    if (!any) return std::nullopt;
    return size;
}

}  // namespace clerestory
