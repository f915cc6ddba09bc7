#include "plan/effects/shadow_pictures.h"

#include "plan/visibility/mirror.h"
#include "plan/visibility/view.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

namespace clerestory {
namespace {

constexpr std::uint32_t kMaxMapEdge = 4096;
// Distance from a light within which nothing hides it, relative to the diagonal of the scene.
constexpr double kLightNearShare = 1e-4;
// A wider cone is six pictures.
constexpr double kMaxConeCosine = 0.35;
// The picture of a directional light shows all places where casters will ever be if these are at
// most so much larger than the casters that do not change.
constexpr double kMaxGrowth = 1.5;

bool isSurface(const Stage& stage, const Surface& surface) {
    const Instance& instance = stage.scene.instances[surface.instance];
    return stage.scene.meshes[instance.mesh].primitive == Primitive::triangles;
}

// One-sided and flat, with its front to the light: its back is not seen from there.
bool facesSun(const Stage& stage, const Surface& surface, const glm::dvec3& toLight) {
    if (surface.flatPart == kNone || stage.material(surface).doubleSided) return false;
    const Instance& instance = stage.scene.instances[surface.instance];
    const auto plane = transformed(stage.scene.flatParts[surface.flatPart].plane(),
                                   stage.pose.worldFromNode[instance.node]);
    return plane && glm::dot(plane->normal, toLight) > 0.0;
}

}  // namespace

bool casts(const Stage& stage, const Surface& surface) {
    return isSurface(stage, surface) && surface.instance != stage.scene.ground &&
           surface.glass == Glass::none && stage.material(surface).alphaMode != AlphaMode::blend;
}

bool tints(const Stage& stage, const Surface& surface) {
    return isSurface(stage, surface) && surface.instance != stage.scene.ground &&
           (surface.glass != Glass::none || stage.material(surface).alphaMode == AlphaMode::blend);
}

Casters::Casters(const Stage& stage) {
    if (!stage.scene.clips.empty()) changes_ = instancesThatChange(stage.scene);
    std::uint64_t clusters = 0, changing = 0;
    for (const Surface& surface : stage.surfaces) {
        if (!casts(stage, surface)) continue;
        clusters += surface.clusterCount;
        if (change(surface)) {
            changing += surface.clusterCount;
            moving_ = true;
        } else {
            still_ = true;
        }
    }
    changingShare_ = clusters > 0 ? double(changing) / double(clusters) : 0.0;
}

PictureEdges edgesOf(Preset preset) {
    switch (preset) {
        case Preset::draft:
            return {1024, 512, 384};
        case Preset::standard:
            return {2048, 1024, 512};
        case Preset::fine:
            return {4096, 2048, 1024};
    }
    return {2048, 1024, 512};
}

namespace {

// Whether no triangle of the mesh is in front of another: it shades nothing of itself.
// Conservative; for sheets, boxes and other bodies of few flat parts.
bool isFlatOrConvex(const Scene& scene, const Mesh& mesh) {
    constexpr std::uint32_t kMaxParts = 16;
    if (mesh.flatPartCount > kMaxParts || mesh.deformation != kNone) return false;
    const std::span parts(scene.flatParts.data() + mesh.firstFlatPart, mesh.flatPartCount);
    std::uint32_t clusters = 0;
    for (const FlatPart& part : parts) clusters += part.clusterCount;
    if (clusters != mesh.clusterCount) return false;
    // Each part is flat to 1e-4 of its diagonal.
    const double tolerance = 2e-4 * double(mesh.bounds.diagonal());
    const auto isBehind = [&](const FlatPart& part, const Plane& plane) {
        const glm::dvec3 half = 0.5 * glm::dvec3(part.bounds.extent());
        return plane.distance(glm::dvec3(part.bounds.center())) +
                   glm::dot(glm::abs(plane.normal), half) <=
               tolerance;
    };
    return std::all_of(parts.begin(), parts.end(), [&](const FlatPart& front) {
        return std::all_of(parts.begin(), parts.end(),
                           [&](const FlatPart& other) { return isBehind(other, front.plane()); });
    });
}

// Seen along one axis of the world from the side of the light.
struct Heights {
    int axis;
    double side;  // of the light: 1 or -1

    double bottom(const Bounds& b) const {
        return side > 0.0 ? double(b.min[axis]) : -double(b.max[axis]);
    }
    double top(const Bounds& b) const {
        return side > 0.0 ? double(b.max[axis]) : -double(b.min[axis]);
    }
};

// What is below everything else along an axis: a ground that is one plane, tiles or slabs. It
// shades neither itself nor others outside of the picture of these, most of which it would take.
struct Grounds {
    Heights heights;
    double lowest = 1e300;        // of its bottoms
    std::vector<bool> instances;  // empty: none

    bool contains(const Surface& s) const { return !instances.empty() && instances[s.instance]; }
};

Grounds groundsAlong(const Heights& heights, const Stage& stage, const std::vector<Bounds>& boxes,
                     const std::vector<bool>& moves) {
    // Relative to the size of a ground: other things may sink into it.
    constexpr double kSunk = 0.01;
    const Scene& scene = stage.scene;
    // The lowest bottom of all, and that of the others.
    Index lowest = kNone;
    double least = 1e300, next = 1e300;
    const auto consider = [&](Index i, const Bounds& box) {
        if (box.empty()) return;
        const double bottom = heights.bottom(box);
        if (bottom < least) {
            next = std::exchange(least, bottom);
            lowest = i;
        } else {
            next = std::min(next, bottom);
        }
    };
    for (Index i = 0; i < boxes.size(); ++i) consider(i, boxes[i]);
    consider(kNone, scene.motionReach);
    Grounds grounds{heights};
    for (Index i = 0; i < boxes.size(); ++i) {
        const double others = i == lowest ? next : least;
        const double sunk = kSunk * double(boxes[i].diagonal());
        if (boxes[i].empty() || moves[i] || heights.top(boxes[i]) > others + sunk) continue;
        if (!isFlatOrConvex(scene, scene.meshes[scene.instances[i].mesh])) continue;
        grounds.instances.resize(boxes.size());
        grounds.instances[i] = true;
        grounds.lowest = std::min(grounds.lowest, heights.bottom(boxes[i]));
    }
    return grounds;
}

struct FittedBox {
    Bounds box;         // world; of casters and of what tints light
    bool lasts;         // contains them at all times
    double fall = 0.0;  // the longest way of light from its top to the ground
};

// Without these grounds.
FittedBox fittedBox(const Stage& stage, const Casters& casters, const std::vector<Bounds>& boxes,
                    const std::vector<bool>& moves, const std::vector<Grounds>& grounds,
                    const glm::dvec3& toLight) {
    Bounds all, still, ever = stage.scene.motionReach;
    for (const Surface& surface : stage.surfaces) {
        const bool hides = casts(stage, surface) && !facesSun(stage, surface, toLight);
        const bool isGround = std::any_of(grounds.begin(), grounds.end(),
                                          [&](const Grounds& g) { return g.contains(surface); });
        if (isGround || (!hides && !tints(stage, surface))) continue;
        const Bounds& box = boxes[surface.instance];
        all.add(box);
        if (!casters.change(surface)) still.add(box);
        if (!moves[surface.instance]) ever.add(box);
    }
    const bool keeps =
        casters.mixed() && !still.empty() && ever.diagonal() <= kMaxGrowth * still.diagonal();
    FittedBox fitted{keeps ? ever : all, keeps || !casters.anyChange()};
    for (const Grounds& g : grounds) {
        if (g.instances.empty() || fitted.box.empty()) continue;
        fitted.fall = std::max(fitted.fall, (g.heights.top(fitted.box) - g.lowest) /
                                                std::abs(toLight[g.heights.axis]));
    }
    return fitted;
}

FittedBox boxTowards(const Stage& stage, const Casters& casters, const glm::dvec3& toLight) {
    // Otherwise the picture would hardly be finer.
    constexpr double kMuchSmaller = 0.7;
    const std::vector<bool> moves = instancesThatMove(stage.scene);
    std::vector<Bounds> boxes;
    for (Index i = 0; i < stage.scene.instances.size(); ++i) {
        boxes.push_back(boundsOfInstance(stage.scene, stage.pose, i));
    }
    std::vector<Grounds> grounds;
    for (int axis = 0; axis < 3; ++axis) {
        if (toLight[axis] == 0.0) continue;
        const Heights heights{axis, toLight[axis] > 0.0 ? 1.0 : -1.0};
        grounds.push_back(groundsAlong(heights, stage, boxes, moves));
    }
    const FittedBox with = fittedBox(stage, casters, boxes, moves, {}, toLight);
    const FittedBox without = fittedBox(stage, casters, boxes, moves, grounds, toLight);
    return without.box.diagonal() < kMuchSmaller * with.box.diagonal() ? without : with;
}

glm::dvec3 cornerOf(const Bounds& box, int corner) {
    return {(corner & 1) ? box.max.x : box.min.x, (corner & 2) ? box.max.y : box.min.y,
            (corner & 4) ? box.max.z : box.min.z};
}

// From a direction: the casters fill the picture but for a margin, and depth reaches from the first
// of them to the last of what they may shade.
View sunView(const Stage& stage, const Bounds& casters, const glm::dvec3& toLight, double margin) {
    const glm::dvec3 middle(casters.center());
    const Bounds all = lastingBounds(stage.scene, stage.pose);
    double top = 0.0, bottom = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
        const double height = glm::dot(toLight, cornerOf(casters, corner) - middle);
        top = std::max(top, height);
        bottom = std::min({bottom, height, glm::dot(toLight, cornerOf(all, corner) - middle)});
    }
    const double pad = 0.01 * (top - bottom) + 1e-9;
    const glm::dvec3 eye = middle + toLight * (top + pad);
    const glm::dmat4 worldFromView = worldFromLookAt(
        eye, eye - toLight, std::abs(toLight.y) > 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0));
    const glm::dmat3 axes(worldFromView);
    glm::dvec2 half(1e-9);
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 p = cornerOf(casters, corner);
        half.x = std::max(half.x, std::abs(glm::dot(axes[0], p - middle)));
        half.y = std::max(half.y, std::abs(glm::dot(axes[1], p - middle)));
    }
    View view;
    view.viewFromWorld = glm::dmat4(glm::transpose(axes));
    view.viewFromWorld[3] = glm::dvec4(-(glm::transpose(axes) * eye), 1.0);
    half = 1.01 * half + margin;
    view.clipFromView = orthographic(half.x, half.y, 0.0, top - bottom + 2.0 * pad);
    view.eye = eye;
    view.orthographic = true;
    view.znear = 0.0;
    return view;
}

}  // namespace

std::optional<Shadow> shadowOf(const Stage& stage, const Casters& casters, std::size_t index,
                               const PictureEdges& edges) {
    const PlacedLight& light = stage.lights[index];
    const double znear =
        std::max(1e-9, kLightNearShare * double(lastingBounds(stage.scene, stage.pose).diagonal()));
    if (light.kind == LightKind::directional) {
        const glm::dvec3 toLight = glm::normalize(glm::dvec3(light.toLight));
        const auto [box, lasts, fall] = boxTowards(stage, casters, toLight);
        if (box.empty()) return std::nullopt;
        const double halfShadow = double(light.radius) * fall;
        return Shadow{.light = index,
                      .kind = LightShadow::Kind::one,
                      .edge = edges.sun,
                      .views = {sunView(stage, box, toLight, halfShadow)},
                      .lasts = lasts};
    }
    if (light.kind == LightKind::spot && light.cosOuter > kMaxConeCosine) {
        const glm::dvec3 along = -glm::normalize(glm::dvec3(light.toLight));
        const glm::dmat4 worldFromView =
            worldFromLookAt(light.position, light.position + along,
                            std::abs(along.y) > 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0));
        const glm::dmat3 axes(worldFromView);
        View view;
        view.viewFromWorld = glm::dmat4(glm::transpose(axes));
        view.viewFromWorld[3] = glm::dvec4(-(glm::transpose(axes) * light.position), 1.0);
        view.clipFromView =
            perspective(2.0 * std::acos(double(light.cosOuter)) + 0.02, 1.0, znear, std::nullopt);
        view.eye = light.position;
        view.znear = znear;
        return Shadow{.light = index,
                      .kind = LightShadow::Kind::one,
                      .edge = edges.cone,
                      .views = {view},
                      .lasts = true};
    }
    const auto faces =
        cubeFaceViews(light.position, znear, glm::transpose(stage.settings.mapFromWorld));
    return Shadow{.light = index,
                  .kind = LightShadow::Kind::six,
                  .edge = edges.face,
                  .views = {faces.begin(), faces.end()},
                  .lasts = true};
}

namespace {

std::uint32_t widthOf(const Shadow& shadow) {
    return (shadow.kind == LightShadow::Kind::six ? 3 : 1) * shadow.edge;
}
std::uint32_t heightOf(const Shadow& shadow) {
    return (shadow.kind == LightShadow::Kind::six ? 2 : 1) * shadow.edge;
}

// Places the pictures in rows, of which none is wider than `width`. Returns the height of the map.
std::uint32_t placeInRows(std::vector<Shadow>& shadows, std::uint32_t width) {
    std::uint32_t x = 0, y = 0, rowHeight = 0;
    for (Shadow& shadow : shadows) {
        if (x + widthOf(shadow) > width) {
            y += rowHeight;
            x = rowHeight = 0;
        }
        shadow.first = {x, y, shadow.edge, shadow.edge};
        x += widthOf(shadow);
        rowHeight = std::max(rowHeight, heightOf(shadow));
    }
    return y + rowHeight;
}

}  // namespace

std::optional<MapSize> placeInSmallestMap(std::vector<Shadow>& shadows) {
    constexpr std::uint32_t kStep = 128;
    std::stable_sort(shadows.begin(), shadows.end(),
                     [](const Shadow& a, const Shadow& b) { return heightOf(a) > heightOf(b); });
    std::uint32_t least = 0;
    for (const Shadow& shadow : shadows) least = std::max(least, widthOf(shadow));
    std::optional<MapSize> best;
    for (std::uint32_t width = least; width <= kMaxMapEdge; width += kStep) {
        const std::uint32_t height = placeInRows(shadows, width);
        if (height > kMaxMapEdge) continue;
        if (!best || width * height < best->width * best->height) best = {width, height};
    }
    if (best) placeInRows(shadows, best->width);
    return best;
}

}  // namespace clerestory
