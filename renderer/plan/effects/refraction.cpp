#include "plan/effects/refraction.h"

#include "plan/effects/glass_layers.h"
#include "plan/effects/method_choice.h"
#include "plan/effects/ray_tracing.h"
#include "plan/graph/features.h"
#include "plan/visibility/view.h"
#include "plan/visibility/visibility.h"

#include <algorithm>
#include <cmath>

namespace clerestory {
namespace {

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
    bool mirrored = true;            // a mirrored view shows what each surface reflects
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
        body.mirrored = body.mirrored && side.surface->flatPart != kNone;
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
    const double enclosed = enclosureAt(context, task, body.box);
    std::vector<Candidate> candidates{
        {Method::environment, 0.0, glassEnvironmentError(enclosed)},
        {Method::backdrop,
         milliseconds({.triangles = solid && a.backFaces ? body.triangles : 0.0,
                       .pixels = kGlassPixel * walls * pixels,
                       .copiedPixels = copies * walls * task.width * task.height,
                       .sharing = std::max(1.0, bodies / kBodiesOfLayer),
                       .shading = context.shading,
                       .software = limits.software}),
         solid || body.mirrored ? backdropError(solid, a.backFaces)
                                : unmirroredPaneError(enclosed)}};
    if (limits.rays != Rays::none && !task.captured) {  // captured faces are small and blurred
        const bool processorRays = limits.rays == Rays::processor;
        const double paths = pathsOfRay(a.glassRaySamples, body.roughness, processorRays);
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

void addGlassLayers(ViewContext& context, const ViewTask& task, const SeenView& seen,
                    const DrawScene& behind, std::span<const DrawLists::Behind> through) {
    // Each is drawn over a copy of everything behind it.
    std::vector<GlassLayer> layers = glassLayers(task, seen, through);
    const TargetSpec drawn = context.builder.target(task.target);
    for (std::size_t i = 0; i < layers.size(); ++i) {
        GlassLayer& layer = layers[i];
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
