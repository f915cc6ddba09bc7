#include "plan/effects/refraction.h"

#include "plan/effects/method_choice.h"
#include "plan/effects/ray_tracing.h"
#include "plan/graph/features.h"
#include "plan/visibility/view.h"
#include "plan/visibility/visibility.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace clerestory {
namespace {

// Maximum number of layers of glass behind glass in a view; nearer glass shares the last one.
constexpr std::size_t kMaxGlassLayers = 4;

// Bounds of the whole instance that the surface belongs to, relative to the eye.
Bounds objectBounds(const Stage& stage, const View& view, const SeenSurface& seen) {
    const Instance& instance = stage.scene.instances[seen.surface->instance];
    return transformed(boundsOf(stage.pose, stage.scene.meshes[instance.mesh]),
                       eyeFromLocal(view, stage.pose.worldFromNode[instance.node]));
}

// One piece of glass: the consecutive surfaces of one instance (flat parts and the rest).
struct GlassBody {
    std::size_t first = 0, end = 0;  // range of SeenView::surfaces
    Bounds box;                      // relative to the eye
    double share = 0.0;              // fraction of the picture, 0..1
    double roughness = 0.0;          // of the roughest surface, 0..1
    double triangles = 0.0;          // in view
};
GlassBody bodyFrom(const SeenView& seen, std::size_t first) {
    GlassBody body{.first = first, .end = first};
    const Index instance = seen.surfaces[first].surface->instance;
    for (; body.end < seen.surfaces.size(); ++body.end) {
        const SeenSurface& side = seen.surfaces[body.end];
        if (side.surface->instance != instance) break;
        body.box.add(side.box);
        body.share = std::min(1.0, body.share + side.share);
        body.roughness = std::max(body.roughness, double{side.surface->roughness});
        for (const SeenCluster& c : side.clusters) body.triangles += c.indexCount / 3.0;
    }
    return body;
}

std::vector<GlassBody> glassBodies(const SeenView& seen) {
    std::vector<GlassBody> bodies;
    for (std::size_t first = 0; first < seen.surfaces.size();) {
        const GlassBody body = bodyFrom(seen, first);
        if (seen.surfaces[first].surface->glass != Glass::none) bodies.push_back(body);
        first = body.end;
    }
    return bodies;
}

// A copy with its blurred levels takes as much as so many copies, and a pixel that looks through
// glass at a copy as so many pixels of other surfaces.
constexpr double kCopiesWithLevels = 3.5, kGlassPixel = 1.5;

// Pieces of glass that lie in one layer, whose copy they share; a mean over scenes.
constexpr double kBodiesOfLayer = 3.0;

// bodies: pieces of glass in the view, this one included. first: a surface of the body.
std::vector<Candidate> candidatesFor(ViewContext& context, const ViewTask& task,
                                     const GlassBody& body, const Surface& first, double bodies) {
    const Accuracy& a = context.stage.settings.accuracy;
    const DeviceLimits& limits = context.frame.limits;
    const double pixels = body.share * task.width * task.height;
    // Rough glass reads levels of the copy.
    const double copies = body.roughness > kSharpRoughness ? kCopiesWithLevels : 1.0;
    const bool solid = first.glass == Glass::solid;
    const double walls = first.shell ? 2.0 : 1.0;
    std::vector<Candidate> candidates{
        {Method::environment, 0.0, glassEnvironmentError(enclosureAt(context, task, body.box))},
        {Method::backdrop,
         milliseconds({.triangles = solid && a.backFaces ? body.triangles : 0.0,
                       .pixels = kGlassPixel * walls * pixels,
                       .copiedPixels = copies * walls * task.width * task.height,
                       .sharing = std::max(1.0, bodies / kBodiesOfLayer),
                       .shading = context.shading,
                       .software = limits.software}),
         backdropError(solid, a.backFaces)}};
    if (limits.rays != Rays::none && !task.captured) {  // captured faces are small and blurred
        const bool processorRays = limits.rays == Rays::processor;
        const double paths = pathsOfRay(a.raySamples, body.roughness, processorRays);
        candidates.push_back({Method::traced,
                              milliseconds({.rayPixels = pixels,
                                            .rays = glassRaySegments(a.bounces),
                                            .paths = paths,
                                            .density = rayDensity(a.preset, processorRays),
                                            .sharing = bodies,
                                            .software = limits.software,
                                            .processorRays = processorRays}),
                              tracedError(body.roughness, paths)});
    }
    return candidates;
}

Features featuresOf(const Material& material, Method method) {
    Features features = 0;
    if (material.transmissionTexture.present()) features |= FEATURE_TRANSMISSION_MAP;
    if (material.thickness > 0.0f && material.thicknessTexture.present()) {
        features |= FEATURE_THICKNESS_MAP;
    }
    for (const TextureSlot* slot : {&material.transmissionTexture, &material.thicknessTexture}) {
        if (slot->present() && slot->transformed()) features |= FEATURE_TEXTURE_TRANSFORM;
        if (slot->present() && slot->texCoord == 1) features |= FEATURE_SECOND_TEXCOORD;
    }
    switch (method) {
        case Method::traced:
            return features | FEATURE_TRACED_GLASS;
        case Method::backdrop:
            return features | FEATURE_GLASS | FEATURE_BACKDROP;
        default:
            return features | FEATURE_GLASS;
    }
}

// Adds a pass for the back faces of the solid glass of a layer if the request enables it, and marks
// the draws that read it. Returns its target, or none.
TargetId addBackFaces(ViewContext& context, const ViewTask& task, std::vector<Draw>& glass,
                      const std::string& layer) {
    DrawBackFaces work{.view = task.view};
    for (Draw& draw : glass) {
        const bool solid =
            (draw.features & FEATURE_SOLID) && !(draw.features & FEATURE_DOUBLE_SIDED);
        if (!context.stage.settings.accuracy.backFaces || !solid) continue;
        draw.features |= FEATURE_BACK_FACES;
        work.draws.push_back(draw);
        work.draws.back().features = 0;
    }
    if (work.draws.empty()) return kNoTarget;
    const TargetSpec drawn = context.builder.target(task.target);
    const TargetId target = context.builder.addTarget({.name = "backFaces",
                                                       .format = Format::rgba16f,
                                                       .width = drawn.width,
                                                       .height = drawn.height,
                                                       .depth = true});
    context.builder.addPass({.name = nameOf(task.subject) + ":backFaces",
                             .subject = task.subject,
                             .effect = Effect::refraction,
                             .generation = task.generation,
                             .target = target,
                             .reason = "exit points of solid glass, layer " + layer,
                             .work = std::move(work)});
    return target;
}

}  // namespace

void chooseRefraction(ViewContext& context, const ViewTask& task, SeenView& seen) {
    const Stage& stage = context.stage;
    if (!stage.settings.effects.refraction) return;
    const std::vector<GlassBody> bodies = glassBodies(seen);
    for (const GlassBody& body : bodies) {
        const Surface& surface = *seen.surfaces[body.first].surface;
        const Subject subject{Subject::Kind::glass, objectName(stage.scene, surface)};
        if (body.share * task.width * task.height < 1.0) {
            skip(context, task, subject, Effect::refraction, "smaller than a pixel");
            continue;
        }
        if (skipIfOccluded(context, task, subject, Effect::refraction, body.box)) continue;
        const bool solid = surface.glass == Glass::solid;
        const Method method =
            chooseMethod(context, task,
                         {subject, Effect::refraction, body.share,
                          noticedShare(body.share, stage.settings.accuracy.preset),
                          requestedMethod(stage.settings.accuracy.glass, Method::backdrop)},
                         candidatesFor(context, task, body, surface, double(bodies.size())));
        Features features = featuresOf(stage.material(surface), method);
        if (solid) features |= FEATURE_SOLID;
        // From inside a body the eye sees the backs of its faces.
        if (solid && distanceTo(objectBounds(stage, task.view, seen.surfaces[body.first])) == 0.0) {
            features |= FEATURE_DOUBLE_SIDED;
        }
        for (std::size_t i = body.first; i < body.end; ++i) {
            seen.surfaces[i].features |= features;
            seen.surfaces[i].overBackdrop = method == Method::backdrop;
        }
    }
}

namespace {

// Whether two boxes have more than this share of the smaller one in common, 0..1.
bool overlap(const ScreenBox& a, const ScreenBox& b, double share) {
    if (!a.overlaps(b)) return false;
    const ScreenBox common{glm::max(a.low, b.low), glm::min(a.high, b.high)};
    return common.share() > share * std::min(a.share(), b.share());
}

struct Layer {
    std::vector<ScreenBox> boxes;  // of its glass
    ScreenBox whole;               // around all that it draws
    bool rough = false;
    std::vector<Draw> glassDraws, blendedDraws;

    // Whether a part of the box may lie in front of what the layer draws.
    bool isBehind(const ScreenBox& box, double leastShared) const {
        if (!box.overlaps(whole)) return false;
        return !blendedDraws.empty() || boxes.size() > kMaxBoxes ||
               std::any_of(boxes.begin(), boxes.end(), [&](const ScreenBox& other) {
                   return overlap(box, other, leastShared);
               });
    }
    void add(const ScreenBox& box) {
        if (box.empty()) return;
        whole = whole.empty()
                    ? box
                    : ScreenBox{glm::min(whole.low, box.low), glm::max(whole.high, box.high)};
    }
    static constexpr std::size_t kMaxBoxes = 256;  // beyond it, the whole decides
};

// Layers of glass, far to near. What is added lies in front of what was added before where both
// overlap, by more than the given share of the smaller box.
class GlassLayers {
public:
    GlassLayers(std::size_t most, double leastShared) : most_(most), leastShared_(leastShared) {}

    // The layer that glass joins: the one after the last that it covers a part of.
    std::size_t addGlass(const ScreenBox& box, bool rough) {
        const std::size_t wanted = inFrontOf(box), at = std::min(wanted, most_ - 1);
        enough_ &= at == wanted;
        if (at == layers_.size()) layers_.emplace_back();
        layers_[at].boxes.push_back(box);
        layers_[at].add(box);
        layers_[at].rough |= rough;
        return at;
    }
    void addDraw(std::size_t layer, const Draw& draw) { layers_[layer].glassDraws.push_back(draw); }

    // Blended draws follow the glass of their layer. There is glass already.
    void addBlended(const ScreenBox& box, const Draw& draw) {
        const std::size_t front = inFrontOf(box);
        Layer& layer = layers_[front == 0 ? 0 : front - 1];
        layer.blendedDraws.push_back(draw);
        layer.add(box);
    }

    bool enough() const { return enough_; }  // each glass has a layer of its own
    std::vector<Layer>& layers() { return layers_; }

private:
    std::size_t inFrontOf(const ScreenBox& box) const {
        std::size_t layer = layers_.size();
        while (layer > 0 && !layers_[layer - 1].isBehind(box, leastShared_)) --layer;
        return layer;
    }

    std::size_t most_;
    double leastShared_;
    bool enough_ = true;
    std::vector<Layer> layers_;
};

Draw facing(Draw draw, DrawnFaces faces) {
    draw.faces = faces;
    return draw;
}

// Glass joins a layer in front of the other glass that it overlaps. Clear panes are ordered by
// cluster, because all windows of a car are one mesh and one is visible through another; shells by
// their faces: what is within is between their far and their near wall.
GlassLayers glassLayers(const ViewTask& task, const SeenView& seen,
                        std::span<const DrawLists::Behind> through, double leastShared,
                        bool bothWalls) {
    const std::size_t most = task.generation == 0 ? kMaxGlassLayers : 1;
    GlassLayers layers(most, leastShared);
    std::map<std::size_t, std::size_t> layerOf, nearest;  // by index of SeenView::surfaces
    std::map<Index, std::size_t> layerOfBody;  // by instance: one layer for all sides of a body
    for (std::size_t i = 0; i < through.size(); ++i) nearest[through[i].seen] = i;
    std::map<std::size_t, std::vector<Draw>> nearWalls;
    for (std::size_t i = 0; i < through.size(); ++i) {
        const DrawLists::Behind& item = through[i];
        if (!item.glass) {
            layers.addBlended(screenBox(task.view, item.box), item.draw);
            continue;
        }
        const Surface& surface = *seen.surfaces[item.seen].surface;
        const ScreenBox whole = screenBox(task.view, seen.surfaces[item.seen].box);
        const bool rough = surface.roughness > kSharpRoughness;
        if (surface.shell && bothWalls && most > 1) {
            if (!layerOf.contains(item.seen)) layerOf[item.seen] = layers.addGlass(whole, rough);
            layers.addDraw(layerOf[item.seen], facing(item.draw, DrawnFaces::back));
            nearWalls[item.seen].push_back(facing(item.draw, DrawnFaces::front));
            if (nearest[item.seen] != i) continue;
            const std::size_t near = layers.addGlass(whole, rough);
            for (const Draw& draw : nearWalls[item.seen]) layers.addDraw(near, draw);
            continue;
        }
        if (surface.glass == Glass::solid && layerOfBody.contains(surface.instance)) {
            layerOf[item.seen] = layerOfBody[surface.instance];
        }
        // Rough panes are not ordered by cluster: their blur would include their neighbours.
        const bool apart = surface.glass == Glass::pane && !rough;
        if (apart || !layerOf.contains(item.seen)) {
            const ScreenBox box = apart ? screenBox(task.view, item.box) : whole;
            layerOf[item.seen] = layerOfBody[surface.instance] = layers.addGlass(box, rough);
        }
        layers.addDraw(layerOf[item.seen], item.draw);
    }
    return layers;
}

// Boxes are larger than what is in them, those of a turned ball by 60 %. If the layers do not
// suffice, glass that overlaps by less than this shares one: where it does overlap, the nearest
// glass hides the other.
constexpr double kSmallOverlap = 0.25;

}  // namespace

void addGlassLayers(ViewContext& context, const ViewTask& task, const SeenView& seen,
                    const DrawScene& behind, std::span<const DrawLists::Behind> through) {
    // Drawn far to near, each over a copy of everything behind it.
    GlassLayers ordered = glassLayers(task, seen, through, 0.0, true);
    if (!ordered.enough()) ordered = glassLayers(task, seen, through, kSmallOverlap, true);
    // The order of bodies matters more than the far walls of each.
    if (!ordered.enough()) ordered = glassLayers(task, seen, through, 0.0, false);
    std::vector<Layer>& layers = ordered.layers();
    const TargetSpec drawn = context.builder.target(task.target);
    for (std::size_t i = 0; i < layers.size(); ++i) {
        Layer& layer = layers[i];
        const TargetId backdrop = context.builder.addTarget(
            {.name = "backdrop",
             .format = Format::rgba16f,
             .width = drawn.width,
             .height = drawn.height,
             .levels = layer.rough ? pictureLevels(drawn.width, drawn.height) : 1});
        const std::string of = std::to_string(i + 1) + " of " + std::to_string(layers.size());
        context.builder.addPass({.name = nameOf(task.subject) + ":backdrop",
                                 .subject = task.subject,
                                 .effect = Effect::refraction,
                                 .generation = task.generation,
                                 .target = backdrop,
                                 .reason = layer.rough ? "background of rough glass, layer " + of
                                                       : "background of glass, layer " + of,
                                 .work = CopyBackdrop{task.target, task.face}});
        const TargetId backFaces = addBackFaces(context, task, layer.glassDraws, of);
        addDrawnPass(context, task,
                     {.name = nameOf(task.subject) + ":glass",
                      .subject = task.subject,
                      .effect = Effect::refraction,
                      .generation = task.generation,
                      .target = task.target,
                      .reason = "glass over its backdrop, layer " + of,
                      .work = DrawGlass{.face = task.face,
                                        .view = task.view,
                                        .map = behind.map,
                                        .environment = behind.environment,
                                        .backdrop = backdrop,
                                        .backFaces = backFaces,
                                        .background = behind.background,
                                        .reflections = behind.reflections,
                                        .glassDraws = std::move(layer.glassDraws),
                                        .blendedDraws = std::move(layer.blendedDraws)}});
    }
}

}  // namespace clerestory
