#include "plan/effects/shadow_pictures.h"

#include "plan/visibility/mirror.h"
#include "plan/visibility/view.h"

#include <algorithm>
#include <cmath>

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

Bounds worldBox(const Stage& stage, const Surface& surface) {
    const Instance& instance = stage.scene.instances[surface.instance];
    return transformed(boundsOf(stage.pose, stage.scene.meshes[instance.mesh]),
                       stage.pose.worldFromNode[instance.node]);
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

struct FittedBox {
    Bounds box;  // world
    bool lasts;  // contains all casters at all times
};

FittedBox boxTowards(const Stage& stage, const Casters& casters, const glm::dvec3& toLight) {
    Bounds all, still;
    for (const Surface& surface : stage.surfaces) {
        if (!casts(stage, surface) || facesSun(stage, surface, toLight)) continue;
        all.add(worldBox(stage, surface));
        if (!casters.change(surface)) still.add(worldBox(stage, surface));
    }
    if (!casters.mixed()) return {all, !casters.anyChange()};
    const Bounds ever = lastingBounds(stage.scene, stage.pose);
    if (still.empty() || ever.diagonal() > kMaxGrowth * still.diagonal()) return {all, false};
    return {ever, true};
}

// From a direction: the casters fill the picture, and depth reaches over the whole scene.
View sunView(const Stage& stage, const Bounds& casters, const glm::dvec3& toLight) {
    const glm::dvec3 middle(casters.center());
    const double reach = 2.0 * double(lastingBounds(stage.scene, stage.pose).diagonal()) + 1e-9;
    const glm::dvec3 eye = middle + toLight * reach;
    const glm::dmat4 worldFromView = worldFromLookAt(
        eye, middle, std::abs(toLight.y) > 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0));
    const glm::dmat3 axes(worldFromView);
    glm::dvec2 half(1e-9);
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 p((corner & 1) ? casters.max.x : casters.min.x,
                           (corner & 2) ? casters.max.y : casters.min.y,
                           (corner & 4) ? casters.max.z : casters.min.z);
        half.x = std::max(half.x, std::abs(glm::dot(axes[0], p - middle)));
        half.y = std::max(half.y, std::abs(glm::dot(axes[1], p - middle)));
    }
    View view;
    view.viewFromWorld = glm::dmat4(glm::transpose(axes));
    view.viewFromWorld[3] = glm::dvec4(-(glm::transpose(axes) * eye), 1.0);
    view.clipFromView = orthographic(half.x * 1.01, half.y * 1.01, 0.0, 2.0 * reach);
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
        const auto [box, lasts] = boxTowards(stage, casters, toLight);
        if (box.empty()) return std::nullopt;
        return Shadow{.light = index,
                      .kind = LightShadow::Kind::one,
                      .edge = edges.sun,
                      .views = {sunView(stage, box, toLight)},
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
