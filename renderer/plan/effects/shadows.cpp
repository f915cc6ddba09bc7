#include "plan/effects/shadows.h"

#include "plan/cost/cost.h"
#include "plan/graph/features.h"
#include "plan/graph/plan_hash.h"
#include "plan/visibility/draws.h"
#include "plan/visibility/lighting.h"
#include "plan/visibility/mirror.h"
#include "plan/visibility/view.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <numeric>
#include <optional>

namespace clerestory {
namespace {

// Lights with a shadow; the brightest have one.
constexpr std::size_t kMaxShadows = 16;
constexpr std::uint32_t kMaxMapEdge = 4096;
// Distance from a light within which nothing hides it, relative to the diagonal of the scene.
constexpr double kLightNearShare = 1e-4;
// A wider cone is six pictures.
constexpr double kMaxConeCosine = 0.35;

// Edges of pictures, texels.
struct Edges {
    std::uint32_t sun, cone, face;
};
Edges edgesOf(Preset preset) {
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

// The pictures of a light that contributes less than this share have half the edges.
constexpr double kWeakShare = 0.08;
Edges edgesFor(const Edges& edges, double share) {
    if (share >= kWeakShare) return edges;
    return {edges.sun / 2, edges.cone / 2, edges.face / 2};
}

// Of the disc of a light with a radius.
std::uint32_t samplesOf(Preset preset) {
    return preset == Preset::draft ? 8 : preset == Preset::fine ? 48 : 24;
}

bool isSurface(const Stage& stage, const Surface& surface) {
    const Instance& instance = stage.scene.instances[surface.instance];
    return stage.scene.meshes[instance.mesh].primitive == Primitive::triangles;
}

// The ground is below everything that it could shade.
bool casts(const Stage& stage, const Surface& surface) {
    return isSurface(stage, surface) && surface.instance != stage.scene.ground &&
           surface.glass == Glass::none && stage.material(surface).alphaMode != AlphaMode::blend;
}

// Some light passes it.
bool tints(const Stage& stage, const Surface& surface) {
    return isSurface(stage, surface) && surface.instance != stage.scene.ground &&
           (surface.glass != Glass::none || stage.material(surface).alphaMode == AlphaMode::blend);
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

// From a direction: the casters fill the picture, and depth reaches over the whole scene.
std::optional<View> sunView(const Stage& stage, const glm::dvec3& toLight) {
    Bounds casters;
    for (const Surface& surface : stage.surfaces) {
        if (casts(stage, surface) && !facesSun(stage, surface, toLight)) {
            casters.add(worldBox(stage, surface));
        }
    }
    if (casters.empty()) return std::nullopt;
    const Bounds all = worldBounds(stage.scene, stage.pose);
    const glm::dvec3 middle(casters.center());
    const double reach = 2.0 * double(all.diagonal()) + 1e-9;
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

// A light and its pictures.
struct Shadow {
    std::size_t light;
    LightShadow::Kind kind;
    std::uint32_t edge;
    std::vector<View> views;
    TargetRect first;
};

std::optional<Shadow> shadowOf(const Stage& stage, std::size_t index, const Edges& edges) {
    const PlacedLight& light = stage.lights[index];
    const double znear =
        std::max(1e-9, kLightNearShare * double(lastingBounds(stage.scene, stage.pose).diagonal()));
    if (light.kind == LightKind::directional) {
        const auto view = sunView(stage, glm::normalize(glm::dvec3(light.toLight)));
        if (!view) return std::nullopt;
        return Shadow{index, LightShadow::Kind::one, edges.sun, {*view}, {}};
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
        return Shadow{index, LightShadow::Kind::one, edges.cone, {view}, {}};
    }
    const auto faces =
        cubeFaceViews(light.position, znear, glm::transpose(stage.settings.mapFromWorld));
    return Shadow{index, LightShadow::Kind::six, edges.face, {faces.begin(), faces.end()}, {}};
}

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

struct MapSize {
    std::uint32_t width, height;
};

// Places the pictures in the smallest map. Returns its size, or nothing if it would be too large.
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

// llvmpipe compiles different code for textures whose edges are powers of two, so no map has such
// edges. Two more texels keep the map of tints exactly half as large.
std::uint32_t edgeOfMap(std::uint32_t texels) {
    return std::has_single_bit(texels) ? texels + 2 : texels;
}

constexpr Features kHoles = FEATURE_BASE_COLOR_MAP | FEATURE_VERTEX_COLOR |
                            FEATURE_TEXTURE_TRANSFORM | FEATURE_SECOND_TEXCOORD;

Features featuresOfCaster(const Stage&, const SeenSurface& seen, const SeenView&) {
    constexpr Features kShape = FEATURE_MASK | FEATURE_DOUBLE_SIDED;
    return seen.features & ((seen.features & FEATURE_MASK) != 0 ? kShape | kHoles : kShape);
}

// Both faces of solid glass count.
Features featuresOfTint(const Stage&, const SeenSurface& seen, const SeenView& all) {
    constexpr Features kLook = kHoles | FEATURE_MASK | FEATURE_BLEND | FEATURE_DOUBLE_SIDED |
                               FEATURE_DEFAULT_NUMBERS | FEATURE_METALLIC_ROUGHNESS_MAP |
                               FEATURE_PACKED_NORMAL;
    Features features = seen.features & kLook;
    if (seen.surface->glass == Glass::none) return features;
    features |=
        FEATURE_GLASS | (all.glassFeatures & (FEATURE_TRANSMISSION_MAP | FEATURE_THICKNESS_MAP |
                                              FEATURE_TEXTURE_TRANSFORM | FEATURE_SECOND_TEXCOORD));
    if (seen.surface->glass == Glass::solid) features |= FEATURE_SOLID | FEATURE_DOUBLE_SIDED;
    return features;
}

using Chooses = bool (*)(const Stage&, const Surface&);
using FeaturesOf = Features (*)(const Stage&, const SeenSurface&, const SeenView&);

std::vector<Draw> drawsFrom(const Stage& stage, const View& view, Chooses chooses,
                            FeaturesOf featuresOf) {
    std::vector<Draw> draws;
    const SeenView all = seenFrom(stage, view);
    for (const SeenSurface& seen : all.surfaces) {
        if (!chooses(stage, *seen.surface)) continue;
        const Features features = featuresOf(stage, seen, all);
        for (const SeenCluster& cluster : seen.clusters) {
            draws.push_back({.instance = seen.surface->instance,
                             .material = seen.surface->material,
                             .firstIndex = cluster.firstIndex,
                             .indexCount = cluster.indexCount,
                             .features = features});
        }
    }
    std::stable_sort(draws.begin(), draws.end(), [](const Draw& a, const Draw& b) {
        return a.features != b.features ? a.features < b.features : a.material < b.material;
    });
    return draws;
}

std::uint64_t keyOf(std::string_view name, const Stage& stage, const std::vector<Shadow>& shadows) {
    PlanHash hash;
    hash.add(name);
    hash.add(stage.scene.contentHash);
    hash.add(stage.scene.indices.size());  // refined meshes (light/refinement.h) round differently
    hash.add(stage.materialsHash);
    for (const glm::dmat4& m : stage.pose.worldFromNode) hash.add(m);
    for (const auto& deformed : stage.pose.deformed) hash.add(deformed->hash);
    for (const Shadow& shadow : shadows) {
        hash.add(shadow.kind);
        hash.add(shadow.first.x);
        hash.add(shadow.first.y);
        hash.add(shadow.edge);
        hash.add(shadow.views.front().viewFromWorld);
        hash.add(shadow.views.front().clipFromView);
    }
    return hash.value();
}

// A target for which every light draws its pictures.
struct PictureTarget {
    TargetId id = kNoTarget;
    std::uint32_t scale = 1;  // how much smaller than the shadow map it is
    std::string passes;       // the beginning of their names
    std::string reason;
};

template <class WorkOf>
void addPictures(PlanBuilder& builder, const std::vector<Shadow>& shadows,
                 const PictureTarget& target, WorkOf workOf) {
    for (const Shadow& shadow : shadows) {
        const std::uint32_t edge = shadow.edge / target.scale;
        for (std::uint32_t i = 0; i < shadow.views.size(); ++i) {
            const TargetRect tile{shadow.first.x / target.scale + i % 3 * edge,
                                  shadow.first.y / target.scale + i / 3 * edge, edge, edge};
            builder.addPass({.name = target.passes + std::to_string(shadow.light),
                             .subject = Subject{Subject::Kind::lights},
                             .effect = Effect::shadows,
                             .target = target.id,
                             .reason = target.reason,
                             .work = workOf(shadow.views[i], tile)});
        }
    }
}

// ---- which lights have a shadow ----------------------------------------------------------------

// Boxes of at most this many clusters represent the scene.
constexpr std::size_t kSampledClusters = 512;

// For each light the root mean square of its share of the light on the scene's surfaces, 0..1.
std::vector<double> sharesOf(const Stage& stage) {
    // A ground would outweigh all other surfaces; it counts if nothing else is lit.
    const bool onGround =
        std::none_of(stage.surfaces.begin(), stage.surfaces.end(), [&](const Surface& s) {
            return s.instance != stage.scene.ground && !stage.material(s).unlit;
        });
    std::size_t clusters = 0;
    for (const Surface& surface : stage.surfaces) clusters += surface.clusterCount;
    const std::size_t step = std::max<std::size_t>(clusters / kSampledClusters, 1);
    const double around = double{stage.settings.environmentIntensity} *
                          double{stage.environment.meanRadiance} * std::numbers::pi;
    std::vector<double> squares(stage.lights.size()), strengths(stage.lights.size());
    double weights = 0.0;
    std::size_t number = 0;
    for (const Surface& surface : stage.surfaces) {
        if ((surface.instance == stage.scene.ground) != onGround) continue;
        const Instance& instance = stage.scene.instances[surface.instance];
        const Mesh& mesh = stage.scene.meshes[instance.mesh];
        for (std::uint32_t c = 0; c < surface.clusterCount; ++c, ++number) {
            if (number % step != 0 || stage.material(surface).unlit) continue;
            const Bounds box = transformed(boundsOf(stage.scene, stage.pose, mesh,
                                                    surface.firstCluster + c - mesh.firstCluster),
                                           stage.pose.worldFromNode[instance.node]);
            const double area = double(box.diagonal()) * double(box.diagonal());
            double all = around;
            for (std::size_t i = 0; i < stage.lights.size(); ++i) {
                strengths[i] = meanIrradiance(stage.lights[i], glm::dvec3(0.0), box);
                all += strengths[i];
            }
            weights += area;
            for (std::size_t i = 0; i < stage.lights.size(); ++i) {
                const double share = all > 0.0 ? strengths[i] / all : 0.0;
                squares[i] += area * share * share;
            }
        }
    }
    for (double& s : squares) s = std::sqrt(s / std::max(weights, 1e-30));
    return squares;
}

std::string nameOf(const Stage& stage, std::size_t light) {
    static constexpr const char* kKinds[] = {"point", "spot", "directional"};
    return std::string(kKinds[static_cast<int>(stage.lights[light].kind)]) + " light " +
           std::to_string(light + 1);
}

struct ShadowedLight {
    std::size_t light;
    double share;
};

// The lights for which the cost model favours a shadow, in the order of `order`. Chosen for the
// scene, not for the view: pictures from lights stay resident while the camera moves.
std::vector<ShadowedLight> worthAShadow(const FrameContext& context, const Stage& stage,
                                        PlanBuilder& builder, const std::vector<std::size_t>& order,
                                        double pixels) {
    const std::vector<double> shares = sharesOf(stage);
    const double tolerance = toleranceOf(stage.settings.accuracy.preset);
    std::vector<ShadowedLight> chosen;
    for (const std::size_t light : order) {
        const double share = shares[light];
        const Subject subject{Subject::Kind::lights, nameOf(stage, light)};
        if (share == 0.0) {
            builder.skip(subject, Effect::shadows, "reaches no surface");
            continue;
        }
        const double views = stage.lights[light].kind == LightKind::point ? 6.0 : 1.0;
        const Candidate candidates[] = {
            {Method::unshadowed, 0.0, unshadowedError(share)},
            {Method::shadowMap,
             milliseconds({.triangles = double(triangleCount(stage.scene)),
                           .views = views,
                           .lookups = pixels,
                           .frames = framesPerCapture(!stage.scene.clips.empty()),
                           .software = context.limits.software}),
             shadowMapError(share)}};
        const Candidate& taken = candidates[cheapest(candidates, tolerance)];
        char reason[160];
        std::snprintf(reason, sizeof reason,
                      "%.1f %% of the light, %.1f ms predicted, error %.3f where %.3f is enough",
                      100.0 * share, taken.milliseconds, taken.error, tolerance);
        builder.addDecision({subject.name,
                             subject,
                             Effect::shadows,
                             0,
                             share,
                             taken.method,
                             {std::begin(candidates), std::end(candidates)},
                             reason});
        if (taken.method == Method::shadowMap) chosen.push_back({light, share});
    }
    return chosen;
}

}  // namespace

void planShadows(FramePlan& plan, PlanBuilder& builder, const FrameContext& context,
                 const Stage& stage, double pixels) {
    const Subject subject{Subject::Kind::lights};
    if (!stage.settings.effects.shadows) return;
    std::vector<std::size_t> order(stage.lights.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto power = [&](std::size_t i) {
        const glm::vec3& c = stage.lights[i].intensity;
        return std::max({c.r, c.g, c.b});
    };
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return power(a) > power(b); });
    const bool anything = std::any_of(stage.surfaces.begin(), stage.surfaces.end(),
                                      [&](const Surface& s) { return casts(stage, s); });
    if (order.empty() || !anything) {
        return builder.skip(
            subject, Effect::shadows,
            order.empty() ? "the scene has no punctual light" : "the scene has no opaque surface");
    }
    if (context.convex) {
        return builder.skip(subject, Effect::shadows, "no surface faces another");
    }
    std::vector<ShadowedLight> shadowed = worthAShadow(context, stage, builder, order, pixels);
    if (shadowed.empty()) return;
    if (shadowed.size() > kMaxShadows) {
        builder.skip(subject, Effect::shadows,
                     std::to_string(shadowed.size() - kMaxShadows) + " of " +
                         std::to_string(shadowed.size()) +
                         " lights have no shadow; the brightest " + std::to_string(kMaxShadows) +
                         " have one");
        shadowed.resize(kMaxShadows);
    }
    Edges edges = edgesOf(stage.settings.accuracy.preset);
    std::vector<Shadow> shadows;
    std::optional<MapSize> size;
    while (!size) {
        shadows.clear();
        for (const auto& [light, share] : shadowed) {
            if (auto shadow = shadowOf(stage, light, edgesFor(edges, share))) {
                shadows.push_back(*std::move(shadow));
            }
        }
        if (shadows.empty()) return;
        size = placeInSmallestMap(shadows);
        if (!size) edges = {edges.sun / 2, edges.cone / 2, edges.face / 2};
    }
    TargetSpec spec{.name = "shadows",
                    .format = Format::depth32f,
                    .width = edgeOfMap(size->width),
                    .height = edgeOfMap(size->height),
                    .residentKey = keyOf("shadow map", stage, shadows)};
    const TargetId target = builder.addTarget(spec);
    plan.shadowMap = target;
    for (const Shadow& shadow : shadows) {
        PlacedLight& light = plan.lights[shadow.light];
        light.shadow = LightShadow{shadow.kind, shadow.first, shadow.views.front()};
        if (light.radius > 0.0f) plan.shadowSamples = samplesOf(stage.settings.accuracy.preset);
    }
    if (context.resident.keys.contains(spec.residentKey)) {
        builder.skip(subject, Effect::shadows, "resident and unchanged");
    } else {
        const PictureTarget map{
            .id = target, .passes = "shadows:light", .reason = "depth as seen from the light"};
        addPictures(builder, shadows, map, [&](const View& view, const TargetRect& tile) {
            return DrawShadow{view, tile, drawsFrom(stage, view, casts, featuresOfCaster)};
        });
    }
    const bool anyTints = std::any_of(stage.surfaces.begin(), stage.surfaces.end(),
                                      [&](const Surface& s) { return tints(stage, s); });
    if (!anyTints) return;
    spec = {.name = "shadowTints",
            .format = Format::rgba16f,
            .width = spec.width / 2,
            .height = spec.height / 2,
            .residentKey = keyOf("shadow tints", stage, shadows)};
    plan.shadowTints = builder.addTarget(spec);
    if (context.resident.keys.contains(spec.residentKey)) return;
    const PictureTarget map{.id = plan.shadowTints,
                            .scale = 2,
                            .passes = "shadowTints:light",
                            .reason = "transmittance of glass and blended surfaces"};
    addPictures(builder, shadows, map, [&](const View& view, const TargetRect& tile) {
        return DrawShadowTint{view, tile, drawsFrom(stage, view, tints, featuresOfTint)};
    });
}

}  // namespace clerestory
