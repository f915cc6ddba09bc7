#include "plan/effects/shadows.h"

#include "plan/cost/cost.h"
#include "plan/effects/near_shadows.h"
#include "plan/effects/shadow_pictures.h"
#include "plan/graph/features.h"
#include "plan/visibility/culling.h"
#include "plan/visibility/lighting.h"
#include "plan/visibility/material_features.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <numeric>
#include <optional>

namespace clerestory {
namespace {

// Lights with a shadow; the brightest have one.
constexpr std::size_t kMaxShadows = 16;

// The pictures of a light that contributes less than this share have half the edges.
constexpr double kWeakShare = 0.08;
PictureEdges edgesFor(const PictureEdges& edges, double share) {
    if (share >= kWeakShare) return edges;
    return edges.half();
}

// Of the disc of a light with a radius.
std::uint32_t samplesOf(Preset preset) {
    return preset == Preset::draft ? 8 : preset == Preset::fine ? 48 : 24;
}

// llvmpipe compiles different code for textures whose edges are powers of two, so no map has such
// edges. Two more texels keep the map of tints exactly half as large.
std::uint32_t edgeOfMap(std::uint32_t texels) {
    return std::has_single_bit(texels) ? texels + 2 : texels;
}

constexpr Features kHoles = FEATURE_BASE_COLOR_MAP | FEATURE_VERTEX_COLOR |
                            FEATURE_TEXTURE_TRANSFORM | FEATURE_SECOND_TEXCOORD;

Features featuresOfCaster(const Surface&, Features ofMaterial, Features) {
    constexpr Features kShape = FEATURE_MASK | FEATURE_DOUBLE_SIDED;
    return ofMaterial & ((ofMaterial & FEATURE_MASK) != 0 ? kShape | kHoles : kShape);
}

// Both faces of solid glass count: light is absorbed between them.
Features featuresOfTint(const Surface& surface, Features ofMaterial, Features ofGlass) {
    constexpr Features kLook = kHoles | FEATURE_MASK | FEATURE_BLEND | FEATURE_DOUBLE_SIDED |
                               FEATURE_DEFAULT_NUMBERS | FEATURE_METALLIC_ROUGHNESS_MAP |
                               FEATURE_PACKED_NORMAL;
    Features features = ofMaterial & kLook;
    if (surface.glass == Glass::none) return features;
    const bool solid = surface.glass == Glass::solid;
    features |= FEATURE_GLASS | (solid ? FEATURE_SOLID | FEATURE_DOUBLE_SIDED : 0);
    features |= ofGlass & (FEATURE_TRANSMISSION_MAP | FEATURE_TEXTURE_TRANSFORM |
                           FEATURE_SECOND_TEXCOORD | (solid ? 0 : FEATURE_THICKNESS_MAP));
    return features;
}

// A part of the surfaces that a shadow map or a map of tints shows.
struct Shown {
    std::function<bool(const Surface&)> contains;
    Features (*featuresOf)(const Surface&, Features ofMaterial, Features ofGlass);
};

// See Draw::middle. 0 for a light within the bounds of the body: the light may begin inside.
float middleFrom(const Stage& stage, const View& view, const Instance& instance) {
    const Bounds bounds = transformed(boundsOf(stage.pose, stage.scene.meshes[instance.mesh]),
                                      stage.pose.worldFromNode[instance.node]);
    const glm::dvec3 middle = glm::dvec3(bounds.center()) - view.eye;
    if (view.orthographic)
        return static_cast<float>(-(view.viewFromWorld * glm::dvec4(middle, 0.0)).z);
    const bool within =
        glm::all(glm::lessThanEqual(glm::abs(middle), 0.5 * glm::dvec3(bounds.extent())));
    return within ? 0.0f : static_cast<float>(glm::length(middle));
}

std::vector<Draw> drawsFrom(const Stage& stage, const View& view, const Shown& shown) {
    std::vector<Draw> draws;
    const Features ofGlass = texturesOfGlass(stage);
    Culling culling(stage, view);
    for (const Surface& surface : stage.surfaces) {
        if (!shown.contains(surface)) continue;
        const Instance& instance = stage.scene.instances[surface.instance];
        Draw draw{.instance = surface.instance, .material = surface.material};
        const Features ofMaterial =
            materialFeatures(stage.scene, stage.material(surface),
                             stage.scene.meshes[instance.mesh], stage.settings.effects);
        draw.features = shown.featuresOf(surface, ofMaterial, ofGlass);
        if ((draw.features & FEATURE_SOLID) != 0) draw.middle = middleFrom(stage, view, instance);
        culling.eachInView(surface, [&](const Cluster& cluster, const Bounds&) {
            draw.firstIndex = cluster.firstIndex;
            draw.indexCount = cluster.indexCount;
            draws.push_back(draw);
        });
    }
    std::stable_sort(draws.begin(), draws.end(), [](const Draw& a, const Draw& b) {
        return a.features != b.features ? a.features < b.features : a.material < b.material;
    });
    return draws;
}

// Of everything that the map shows, and of nothing else: what moves elsewhere does not change it.
std::uint64_t keyOf(std::string_view name, const Stage& stage, const std::vector<Shadow>& shadows,
                    const MapSize& size, const Shown& shown) {
    PlanHash hash;
    hash.add(name);
    hash.add(size.width);
    hash.add(size.height);
    hash.add(stage.scene.contentHash);
    hash.add(stage.scene.indices.size());  // refined meshes (light/refinement.h) round differently
    for (const Surface& surface : stage.surfaces) {
        if (!shown.contains(surface)) continue;
        const Instance& instance = stage.scene.instances[surface.instance];
        hash.add(surface.instance);
        hash.add(surface.firstCluster);
        hash.add(surface.clusterCount);
        stage.addMaterial(hash, surface.material);
        hash.add(stage.pose.worldFromNode[instance.node]);
        if (const DeformedMesh* mesh =
                deformedMesh(stage.pose, stage.scene.meshes[instance.mesh])) {
            hash.add(mesh->hash);
        }
    }
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

TargetSpec mapSpec(std::string name, const MapSize& size, std::uint64_t key) {
    return {.name = std::move(name),
            .format = Format::depth32f,
            .width = edgeOfMap(size.width),
            .height = edgeOfMap(size.height),
            .residentKey = key};
}

// still: a map of the same size with which each picture begins.
void addDepthPasses(const Stage& stage, PlanBuilder& builder, const std::vector<Shadow>& shadows,
                    TargetId target, const std::string& name, const Shown& shown,
                    TargetId still = kNoTarget) {
    const PictureTarget map{.id = target,
                            .passes = name + ":light",
                            .reason = still == kNoTarget
                                          ? "depth as seen from the light"
                                          : "depth of what changes, over that of the rest"};
    addPictures(builder, shadows, map, [&](const View& view, const TargetRect& tile) {
        return DrawShadow{view, tile, drawsFrom(stage, view, shown), still};
    });
}

bool anyLightMoves(const Scene& scene) {
    const std::vector<bool> moves = nodesThatMove(scene);
    return std::any_of(scene.lights.begin(), scene.lights.end(), [&](const Light& light) {
        return light.node != kNone && moves[light.node];
    });
}

Shown allCasters(const Stage& stage) {
    return {[&](const Surface& s) { return casts(stage, s); }, featuresOfCaster};
}

// Adds a map of its own for what is shown. Its passes are left out if it is resident.
TargetId addDepths(const FrameContext& context, const Stage& stage, PlanBuilder& builder,
                   const std::vector<Shadow>& shadows, const TargetSpec& map, const Shown& shown) {
    const TargetId target = builder.addTarget(map);
    if (context.resident.keys.contains(map.residentKey)) {
        builder.skip(Subject{Subject::Kind::lights}, Effect::shadows, "resident and unchanged");
    } else {
        addDepthPasses(stage, builder, shadows, target, map.name, shown);
    }
    return target;
}

// If some casters change and others do not, the latter have a map of their own, which lasts.
// ofWhole: the part of the map without nearer pictures.
TargetId addShadowMap(const FrameContext& context, const Stage& stage, PlanBuilder& builder,
                      const std::vector<Shadow>& shadows, const MapSize& size,
                      const MapSize& ofWhole, const Casters& casters) {
    const Shown all = allCasters(stage);
    TargetSpec whole = mapSpec("shadows", size, keyOf("shadows", stage, shadows, size, all));
    whole.replaceable = casters.anyChange() || anyLightMoves(stage.scene);
    const bool separate =
        casters.mixed() && !anyLightMoves(stage.scene) &&
        std::all_of(shadows.begin(), shadows.end(), [](const Shadow& s) { return s.lasts; });
    if (!separate || context.resident.keys.contains(whole.residentKey)) {
        return addDepths(context, stage, builder, shadows, whole, all);
    }
    const Shown still{[&](const Surface& s) { return casts(stage, s) && !casters.change(s); },
                      featuresOfCaster};
    const Shown changing{[&](const Surface& s) { return casts(stage, s) && casters.change(s); },
                         featuresOfCaster};
    const TargetId base = addDepths(
        context, stage, builder, shadows,
        mapSpec("stillShadows", ofWhole, keyOf("stillShadows", stage, shadows, ofWhole, still)),
        still);
    const TargetId map = builder.addTarget(whole);
    addDepthPasses(stage, builder, shadows, map, whole.name, changing, base);
    return map;
}

std::uint64_t keyOfNearer(const TargetSpec& map, const std::vector<Shadow>& shadows,
                          const std::vector<PlacedLight>& lights) {
    PlanHash hash;
    hash.add(std::string_view("nearer shadows"));
    hash.add(map.residentKey);
    for (const Shadow& shadow : shadows) {
        for (const NearShadow& picture : lights[shadow.light].shadow->nearer) {
            hash.add(picture.tile.x);
            hash.add(picture.tile.y);
            hash.add(picture.view.clipFromView);
        }
    }
    return hash.value();
}

// Draws the nearer pictures into the shadow map of the plan, in which the others may be resident.
void addNearer(FramePlan& plan, const FrameContext& context, const Stage& stage,
               PlanBuilder& builder, const std::vector<Shadow>& shadows) {
    TargetSpec& map = plan.targets[plan.shadowMap];
    map.partKey = keyOfNearer(map, shadows, plan.lights);
    const bool resident = context.resident.keys.contains(map.residentKey);
    if (resident && context.resident.keys.contains(map.partKey)) return;
    for (const Shadow& shadow : shadows) {
        const LightShadow& placed = *plan.lights[shadow.light].shadow;
        for (const NearShadow& picture : placed.nearer) {
            char reason[96];
            std::snprintf(reason, sizeof reason, "texels of %.2g m; those of the whole have %.2g m",
                          texelOf(picture.view, picture.tile), texelOf(placed.view, placed.tile));
            builder.addPass(
                {.name = "nearShadows:light" + std::to_string(shadow.light),
                 .subject = Subject{Subject::Kind::lights},
                 .effect = Effect::shadows,
                 .target = plan.shadowMap,
                 .reason = reason,
                 .work = DrawShadow{picture.view, picture.tile,
                                    drawsFrom(stage, picture.view, allCasters(stage))}});
        }
    }
}

// Of glass and blended surfaces; kNoTarget if there are none.
TargetId addTints(const FrameContext& context, const Stage& stage, PlanBuilder& builder,
                  const std::vector<Shadow>& shadows, const MapSize& size) {
    const bool any = std::any_of(stage.surfaces.begin(), stage.surfaces.end(),
                                 [&](const Surface& s) { return tints(stage, s); });
    if (!any) return kNoTarget;
    const Shown shown{[&](const Surface& s) { return tints(stage, s); }, featuresOfTint};
    const TargetSpec spec{.name = "shadowTints",
                          .format = Format::rgba16f,
                          .width = edgeOfMap(size.width) / 2,
                          .height = edgeOfMap(size.height) / 2,
                          .residentKey = keyOf("shadow tints", stage, shadows, size, shown)};
    const TargetId target = builder.addTarget(spec);
    if (context.resident.keys.contains(spec.residentKey)) return target;
    const PictureTarget map{.id = target,
                            .scale = 2,
                            .passes = "shadowTints:light",
                            .reason = "transmittance of glass and blended surfaces"};
    addPictures(builder, shadows, map, [&](const View& view, const TargetRect& tile) {
        return DrawShadowTint{view, tile, drawsFrom(stage, view, shown)};
    });
    return target;
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
                                        PlanBuilder& builder, const Casters& casters,
                                        const std::vector<std::size_t>& order, double pixels) {
    const std::vector<double> shares = sharesOf(stage);
    const double tolerance = toleranceOf(stage.settings.accuracy.preset);
    // Casters that do not change are drawn once for many frames.
    const double lasting = framesPerCapture(false);
    const double triangles = double(triangleCount(stage.scene));
    const double changing = casters.changingShare();
    const double drawn =
        casters.mixed() ? triangles * (changing + (1.0 - changing) / lasting) : triangles;
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
             milliseconds({.triangles = drawn,
                           .views = views,
                           .lookups = pixels,
                           .frames = casters.anyChange() ? 1.0 : lasting,
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
                 const Stage& stage, const Observer& observer, double pixels) {
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
    const Casters casters(stage);
    if (order.empty() || !casters.any()) {
        return builder.skip(
            subject, Effect::shadows,
            order.empty() ? "the scene has no punctual light" : "the scene has no opaque surface");
    }
    if (context.convex) {
        return builder.skip(subject, Effect::shadows, "no surface faces another");
    }
    std::vector<ShadowedLight> shadowed =
        worthAShadow(context, stage, builder, casters, order, pixels);
    if (shadowed.empty()) return;
    if (shadowed.size() > kMaxShadows) {
        builder.skip(subject, Effect::shadows,
                     std::to_string(shadowed.size() - kMaxShadows) + " of " +
                         std::to_string(shadowed.size()) +
                         " lights have no shadow; the brightest " + std::to_string(kMaxShadows) +
                         " have one");
        shadowed.resize(kMaxShadows);
    }
    PictureEdges edges = edgesOf(stage.settings.accuracy.preset);
    std::vector<Shadow> shadows;
    std::optional<MapSize> size;
    while (!size) {
        shadows.clear();
        for (const auto& [light, share] : shadowed) {
            if (auto shadow = shadowOf(stage, casters, light, edgesFor(edges, share))) {
                shadows.push_back(*std::move(shadow));
            }
        }
        if (shadows.empty()) return;
        size = placeInSmallestMap(shadows);
        if (!size) edges = edges.half();
    }
    for (const Shadow& shadow : shadows) {
        PlacedLight& light = plan.lights[shadow.light];
        light.shadow = LightShadow{shadow.kind, shadow.first, shadow.views.front(), {}};
        if (light.radius > 0.0f) plan.shadowSamples = samplesOf(stage.settings.accuracy.preset);
    }
    const std::optional<MapSize> withNearer =
        placeNearer(stage, shadows, *size, observer, plan.lights);
    plan.shadowMap =
        addShadowMap(context, stage, builder, shadows, withNearer.value_or(*size), *size, casters);
    plan.wholeShadows = {0, 0, edgeOfMap(size->width), edgeOfMap(size->height)};
    if (withNearer) addNearer(plan, context, stage, builder, shadows);
    plan.shadowTints = addTints(context, stage, builder, shadows, *size);
}

}  // namespace clerestory
