// The walk: what a view sees, who serves it, and the passes that follow.
#include "plan/view_tree.h"

#include "plan/cost/cost.h"
#include "plan/features.h"
#include "plan/visibility/view.h"
#include "plan/visibility/visibility.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>

namespace clerestory {
namespace {

// Layers of glass behind glass that one view keeps apart; what is nearer shares the last one.
constexpr std::size_t kMaxGlassLayers = 4;

// What copying a pixel takes of shading one.
constexpr double kCopiedPixel = 0.04;

std::string format(const char* pattern, double value) {
    char text[160];
    std::snprintf(text, sizeof text, pattern, value);
    return text;
}

}  // namespace

ViewTree::ViewTree(FramePlan& plan, const Stage& stage, const FrameContext& context)
    : plan_(plan),
      stage_(stage),
      environment_(context.environment),
      maps_(context.maps),
      resident_(context.resident),
      limits_(context.limits),
      moves_(stage.scene.clips.empty() ? std::vector<bool>{} : instancesThatMove(stage.scene)),
      sceneBounds_(lastingBounds(stage.scene, stage.pose)),
      sceneTriangles_(triangleCount(stage.scene)) {}

namespace {

std::string bodyName(const Scene& scene, const Surface& surface) {
    const Instance& instance = scene.instances[surface.instance];
    std::string name = scene.nodes[instance.node].name;
    if (name.empty()) name = scene.meshes[instance.mesh].name;
    if (name.empty()) name = "object " + std::to_string(surface.instance + 1);
    return name;
}

}  // namespace

std::string nameOf(const Scene& scene, const Surface& surface) {
    const Instance& instance = scene.instances[surface.instance];
    std::string name = bodyName(scene, surface);
    if (surface.flatPart != kNone) {
        const std::uint32_t part = surface.flatPart - scene.meshes[instance.mesh].firstFlatPart;
        if (part > 0) name += " part " + std::to_string(part + 1);
    }
    return name;
}

// The last level is 2 or 3 pixels wide: at roughness 0.5 a lobe covers half of a picture, and blur
// that stopped short of it would depend on how large the picture happens to be.
std::uint32_t pictureLevels(std::uint32_t width, std::uint32_t height) {
    const auto full = static_cast<std::uint32_t>(std::bit_width(std::min(width, height)));
    return full > 1 ? full - 1 : 1;
}

// Down to faces of 4 texels: fewer hold no more than the harmonics do.
std::uint32_t roughnessLevels(std::uint32_t faceSize) {
    const auto full = static_cast<std::uint32_t>(std::bit_width(faceSize));
    return full > 3 ? full - 2 : 1;
}

double reflectanceSeen(double reflectance, double cosine) {
    const double edge = 1.0 - std::clamp(cosine, 0.0, 1.0);
    return reflectance + (1.0 - reflectance) * edge * edge * edge * edge * edge;
}

TargetId ViewTree::addTarget(TargetSpec spec) {
    plan_.targets.push_back(std::move(spec));
    return static_cast<TargetId>(plan_.targets.size() - 1);
}

// What happens inside child views is not told: their passes speak for themselves.
void ViewTree::skip(const ViewJob& job, std::string name, Effect effect, std::string reason) {
    if (job.generation == 0) {
        plan_.skipped.push_back({std::move(name), effect, std::move(reason)});
    }
}

Method ViewTree::decide(const ViewJob& job, Case about, std::span<const Candidate> candidates) {
    const double weight = job.weight * about.weight;
    const double tolerance = toleranceOf(stage_.request.accuracy.preset) / std::max(weight, 1e-12);
    std::size_t taken = cheapest(candidates, tolerance);
    std::string reason = format("%.1f %% of the frame", 100.0 * about.share);
    const auto asked = std::find_if(candidates.begin(), candidates.end(), [&](const Candidate& c) {
        return about.forced && c.method == *about.forced;
    });
    if (asked != candidates.end()) {
        taken = static_cast<std::size_t>(asked - candidates.begin());
        reason += ", as the request asks";
    } else {
        reason += format(", %.1f ms predicted", candidates[taken].milliseconds) +
                  format(", error %.2f", candidates[taken].error) +
                  format(" where %.2f is enough", std::min(tolerance, 99.0));
    }
    if (job.generation == 0) {
        plan_.decisions.push_back({std::move(about.name),
                                   about.effect,
                                   job.generation,
                                   about.share,
                                   candidates[taken].method,
                                   {candidates.begin(), candidates.end()},
                                   std::move(reason)});
    }
    return candidates[taken].method;
}

bool ViewTree::hidden(const ViewJob& job, const std::string& name, Effect effect,
                      const Bounds& box) {
    if (job.generation > 0) return false;
    const Wall* wall = hiding(walls_, job.view, box);
    if (wall != nullptr) {
        skip(job, name, effect,
             "hidden behind " + nameOf(stage_.scene, stage_.surfaces[wall->surface]));
    }
    return wall != nullptr;
}

std::vector<std::size_t> ViewTree::hiddenFrom(const ViewJob& job) const {
    std::vector<std::size_t> hidden = job.hidden;
    if (moves_.empty() || !job.captured) return hidden;
    std::vector<Wall> walls = wallsOf(stage_, job.view);
    std::erase_if(walls, [&](const Wall& wall) {
        return std::binary_search(hidden.begin(), hidden.end(), wall.surface);
    });
    for (std::size_t i = 0; i < stage_.surfaces.size() && !walls.empty(); ++i) {
        const Instance& instance = stage_.scene.instances[stage_.surfaces[i].instance];
        if (!moves_[stage_.surfaces[i].instance]) continue;
        const Bounds box =
            transformed(boundsOf(stage_.pose, stage_.scene.meshes[instance.mesh]),
                        eyeFromLocal(job.view, stage_.pose.worldFromNode[instance.node]));
        if (hiding(walls, job.view, box) != nullptr) hidden.push_back(i);
    }
    std::sort(hidden.begin(), hidden.end());
    return hidden;
}

SeenView ViewTree::add(const ViewJob& job) {
    if (job.generation == 0) walls_ = wallsOf(stage_, job.view);
    SeenView seen = seenFrom(stage_, job.view, hiddenFrom(job));
    DrawScene drawn{.purpose = job.purpose,
                    .face = job.face,
                    .view = job.view,
                    .sky = stage_.request.environment.visible};
    if (seen.anyLit) drawn.environment = environmentTarget();
    if (drawn.sky || drawn.environment != kNoTarget) drawn.map = environment_.name;
    serveFlat(job, seen, drawn);
    serveCurved(job, seen, drawn);
    serveRough(job, seen);
    serveGlass(job, seen);

    DrawLists lists = drawLists(seen);
    const char* requested = lists.depth.empty()
                                ? "the requested view; no depth prepass, %.1f layers predicted"
                                : "the requested view; depth first, %.1f layers predicted";
    drawn.depthDraws = std::move(lists.depth);
    drawn.opaqueDraws = std::move(lists.opaque);

    const auto firstGlass = std::find_if(lists.through.begin(), lists.through.end(),
                                         [](const DrawLists::Behind& b) { return b.glass; });
    for (auto it = lists.through.begin(); it != firstGlass; ++it) {
        drawn.blendedDraws.push_back(it->draw);
    }
    plan_.passes.push_back(
        {.name = job.name,
         .effect = job.effect,
         .generation = job.generation,
         .target = job.target,
         .reason = job.reason.empty() ? format(requested, seen.overdraw) : job.reason,
         .work = drawn});
    addGlass(job, seen, drawn, {firstGlass, lists.through.end()});
    return seen;
}

// All of what the surface is a part of, relative to the eye.
Bounds ViewTree::bodyOf(const ViewJob& job, const SeenSurface& seen) const {
    const Instance& instance = stage_.scene.instances[seen.surface->instance];
    return transformed(boundsOf(stage_.pose, stage_.scene.meshes[instance.mesh]),
                       eyeFromLocal(job.view, stage_.pose.worldFromNode[instance.node]));
}

// A body's surfaces (its flat sides, and the rest) are one piece of glass to whoever looks.
void ViewTree::serveGlass(const ViewJob& job, SeenView& seen) {
    if (!stage_.request.effects.refraction) return;
    for (std::size_t first = 0, end = 0; first < seen.surfaces.size(); first = end) {
        const SeenSurface& s = seen.surfaces[first];
        Bounds box;
        double share = 0.0, roughness = 0.0;
        for (end = first; end < seen.surfaces.size(); ++end) {  // an instance's follow each other
            const SeenSurface& side = seen.surfaces[end];
            if (side.surface->instance != s.surface->instance) break;
            box.add(side.box);
            share = std::min(1.0, share + side.share);
            roughness = std::max(roughness, double{side.surface->roughness});
        }
        if (s.surface->glass == Glass::none) continue;
        const std::string name = "glass:" + bodyName(stage_.scene, *s.surface);
        const double pixels = share * job.width * job.height;
        if (pixels < 1.0) {
            skip(job, name, Effect::refraction, "smaller than a pixel");
            continue;
        }
        if (hidden(job, name, Effect::refraction, box)) continue;
        const bool solid = s.surface->glass == Glass::solid;
        const double segments = solid ? std::min(4.0, 1.0 + stage_.request.accuracy.bounces) : 2.0;
        std::vector<Candidate> candidates{
            {Method::environment, 0.0, 2.7},
            {Method::backdrop,
             milliseconds({.pixels = kCopiedPixel * job.width * job.height + pixels,
                           .views = 1.0,
                           .software = limits_.software}),
             !solid ? 0.06  // straight through: right but for what it mirrors
             : stage_.request.accuracy.backFaces ? 2.2
                                                 : 2.7}};
        if (limits_.traces && !job.captured) {  // a captured face is small and blurred
            candidates.push_back(
                {Method::traced,
                 milliseconds(
                     {.rayPixels = pixels, .rays = segments, .software = limits_.software}),
                 tracedError(roughness)});
        }
        const std::optional<Method> forced =
            methodAsked(stage_.request.accuracy.glass, Method::backdrop);
        const Method method =
            decide(job, {name, Effect::refraction, share, share, forced}, candidates);
        Features features = solid ? FEATURE_SOLID : 0;
        const Material& material = stage_.material(*s.surface);
        if (material.transmissionTexture.present()) features |= FEATURE_TRANSMISSION_MAP;
        if (material.thickness > 0.0f && material.thicknessTexture.present()) {
            features |= FEATURE_THICKNESS_MAP;
        }
        for (const TextureSlot* slot :
             {&material.transmissionTexture, &material.thicknessTexture}) {
            if (slot->present() && slot->transformed()) features |= FEATURE_TEXTURE_TRANSFORM;
            if (slot->present() && slot->texCoord == 1) features |= FEATURE_SECOND_TEXCOORD;
        }
        // An eye inside a body sees its far faces from their backs.
        if (solid && distanceTo(bodyOf(job, s)) == 0.0) features |= FEATURE_DOUBLE_SIDED;
        switch (method) {
            case Method::traced:
                features |= FEATURE_TRACED_GLASS;
                break;
            case Method::backdrop:
                features |= FEATURE_GLASS | FEATURE_BACKDROP;
                break;
            default:
                features |= FEATURE_GLASS;
                break;
        }
        for (std::size_t i = first; i < end; ++i) {
            seen.surfaces[i].features |= features;
            seen.surfaces[i].overBackdrop = method == Method::backdrop;
        }
    }
}

// The far sides of a layer's solids, where the request wants them; marks the draws that read them.
TargetId ViewTree::addBackFaces(const ViewJob& job, std::vector<Draw>& glass,
                                const std::string& layer) {
    DrawBackFaces work{.view = job.view};
    for (Draw& draw : glass) {
        const bool solid =
            (draw.features & FEATURE_SOLID) && !(draw.features & FEATURE_DOUBLE_SIDED);
        if (!stage_.request.accuracy.backFaces || !solid) continue;
        draw.features |= FEATURE_BACK_FACES;
        work.draws.push_back(draw);
        work.draws.back().features = 0;
    }
    if (work.draws.empty()) return kNoTarget;
    const TargetSpec drawn = plan_.targets[job.target];
    const TargetId target = addTarget({.name = "backFaces",
                                       .format = Format::rgba16f,
                                       .width = drawn.width,
                                       .height = drawn.height,
                                       .depth = true});
    plan_.passes.push_back({.name = job.name + ":backFaces",
                            .effect = Effect::refraction,
                            .generation = job.generation,
                            .target = target,
                            .reason = "where solid glass ends, layer " + layer,
                            .work = std::move(work)});
    return target;
}

// Far to near: each layer is seen against a copy of everything behind it. Glass that lies beside
// other glass shares its layer; what is blended waits for the glass behind it. Of clear panes each
// cluster stands for itself: all windows of a car are one mesh, and one is seen through another.
void ViewTree::addGlass(const ViewJob& job, const SeenView& seen, const DrawScene& behind,
                        std::span<const DrawLists::Behind> through) {
    struct Layer {
        std::vector<ScreenBox> boxes;  // of its glass
        bool rough = false;
        std::vector<Draw> glassDraws, blendedDraws;
    };
    std::vector<Layer> layers;
    std::map<std::size_t, std::size_t> layerOf;  // of a surface
    std::map<Index, std::size_t> layerOfBody;    // a body's sides are not behind each other
    const auto joins = [](const Layer& layer, const ScreenBox& box) {
        return layer.blendedDraws.empty() &&
               std::none_of(layer.boxes.begin(), layer.boxes.end(),
                            [&](const ScreenBox& other) { return box.overlaps(other); });
    };
    for (const DrawLists::Behind& item : through) {
        if (!item.glass) {
            layers.back().blendedDraws.push_back(item.draw);  // the first item is glass
            continue;
        }
        const Surface& surface = *seen.surfaces[item.seen].surface;
        if (surface.glass == Glass::solid && layerOfBody.contains(surface.instance)) {
            layerOf[item.seen] = layerOfBody[surface.instance];
        }
        // Rough ones would be blurred with their own neighbours.
        const bool rough = surface.roughness > kSharpRoughness;
        const bool apart = surface.glass == Glass::pane && !rough;
        if (apart || !layerOf.contains(item.seen)) {
            const bool full = layers.size() == (job.generation == 0 ? kMaxGlassLayers : 1);
            const ScreenBox box =
                screenBox(job.view, apart ? item.box : seen.surfaces[item.seen].box);
            if (layers.empty() || (!full && !joins(layers.back(), box))) layers.emplace_back();
            layers.back().boxes.push_back(box);
            layers.back().rough |= rough;
            layerOf[item.seen] = layerOfBody[surface.instance] = layers.size() - 1;
        }
        layers[layerOf[item.seen]].glassDraws.push_back(item.draw);
    }
    const TargetSpec drawn = plan_.targets[job.target];
    for (std::size_t i = 0; i < layers.size(); ++i) {
        Layer& layer = layers[i];
        const TargetId backdrop =
            addTarget({.name = "backdrop",
                       .format = Format::rgba16f,
                       .width = drawn.width,
                       .height = drawn.height,
                       .levels = layer.rough ? pictureLevels(drawn.width, drawn.height) : 1});
        const std::string of = std::to_string(i + 1) + " of " + std::to_string(layers.size());
        plan_.passes.push_back({.name = job.name + ":backdrop",
                                .effect = Effect::refraction,
                                .generation = job.generation,
                                .target = backdrop,
                                .reason = layer.rough ? "what lies behind rough glass, layer " + of
                                                      : "what lies behind glass, layer " + of,
                                .work = CopyBackdrop{job.target, job.face}});
        const TargetId backFaces = addBackFaces(job, layer.glassDraws, of);
        plan_.passes.push_back({.name = job.name + ":glass",
                                .effect = Effect::refraction,
                                .generation = job.generation,
                                .target = job.target,
                                .reason = "glass over its backdrop, layer " + of,
                                .work = DrawGlass{.face = job.face,
                                                  .view = job.view,
                                                  .map = behind.map,
                                                  .environment = behind.environment,
                                                  .backdrop = backdrop,
                                                  .backFaces = backFaces,
                                                  .reflections = behind.reflections,
                                                  .glassDraws = std::move(layer.glassDraws),
                                                  .blendedDraws = std::move(layer.blendedDraws)}});
    }
}

}  // namespace clerestory
