#include "plan/effects/curved_reflection.h"

#include "plan/effects/environment_map.h"
#include "plan/effects/method_choice.h"
#include "plan/effects/probe_capture.h"
#include "plan/graph/features.h"

#include <algorithm>

namespace clerestory {
namespace {

// Below this roughness one lookup in a blurred level is accurate; see reflection.glsl.
constexpr float kRoughLobe = 0.1f;

// Makes the surface reflect the stored map that its material names, with the material's rotation.
// Returns false if the map is not loaded.
bool reflectStoredMap(ViewContext& context, const ViewTask& task, SeenSurface& s,
                      DrawScene& drawn) {
    const Material& material = context.stage.material(*s.surface);
    const auto found = context.frame.maps.find(material.environmentMap);
    if (found == context.frame.maps.end()) {
        skip(context, task, {Subject::Kind::map, material.environmentMap},
             Effect::environmentReflection, "no environment map of that name is loaded");
        return false;
    }
    const glm::dmat3 worldFromOwn = glm::mat3_cast(glm::normalize(material.environmentRotation));
    drawn.reflections.push_back(
        {.target = mapTarget(context, *found->second, material.mapBlur),
         .ownFromMap =
             glm::transpose(worldFromOwn) * glm::transpose(context.stage.settings.mapFromWorld)});
    s.features |= FEATURE_MAP;
    s.reflection = static_cast<std::uint32_t>(drawn.reflections.size() - 1);
    return true;
}

// reflectors: curved ones in the view, this one included.
std::vector<Candidate> candidatesFor(ViewContext& context, const ViewTask& task,
                                     const SeenSurface& s, const CapturePoint& point,
                                     double reflectors) {
    const DeviceLimits& limits = context.frame.limits;
    const double roughness = s.surface->roughness;
    const double apart = point.placed ? 0.0 : apartFromCenter(context, *s.surface, point);
    // The faces of a cube show the cubes of other reflectors, captured one generation before.
    const double cubes = context.curvedReflectors > 1 ? task.probeGeneration : 1.0;
    const double faceTexels = cubes * point.resolution * point.resolution;
    const double enclosed = enclosureAt(context, task, s.box);
    std::vector<Candidate> candidates{
        {Method::environment, 0.0, environmentError(roughness, enclosed)},
        {Method::probe,
         milliseconds({.draws = 2.0 * cubes * double(context.stage.surfaces.size()),
                       .triangles = 2.0 * cubes * double(context.sceneTriangles),
                       .pixels = 6.0 * faceTexels,
                       .views = 6.0 * cubes,
                       .cubes = cubes,
                       .mapSamples = 8.0 * faceTexels *  // six faces and their levels
                                     context.stage.settings.accuracy.probeSamples,
                       .frames = framesPerCapture(!context.moves.empty()),
                       .shading = context.shading,
                       .software = limits.software}),
         probeError(roughness, apart)}};
    if (limits.rays != Rays::none &&
        !task.captured) {  // captured faces show the previous generation
        const Accuracy& a = context.stage.settings.accuracy;
        const bool processorRays = limits.rays == Rays::processor;
        const double paths = pathsOfRay(a.raySamples, roughness, processorRays);
        candidates.push_back({Method::traced,
                              milliseconds({.rayPixels = s.share * task.width * task.height,
                                            .rays = 1.0,
                                            .paths = paths,
                                            .density = rayDensity(a.preset, processorRays),
                                            .hits = enclosed,
                                            .sharing = reflectors,
                                            .shading = context.shading,
                                            .software = limits.software,
                                            .processorRays = processorRays}),
                              tracedError(roughness, paths)});
    }
    return candidates;
}

// Makes the surface reflect the cube that is captured for it.
void reflectCapturedCube(ViewContext& context, const ViewTask& task, SeenSurface& s,
                         const CapturePoint& point, DrawScene& drawn) {
    ReflectedPicture picture{.target = capturedCube(context, point, task.probeGeneration),
                             .center = point.center};
    // Box for parallax correction: that of the scene, at least as large as the owner.
    picture.proxyMin =
        glm::min(glm::dvec3(context.sceneBounds.min) - point.center, glm::dvec3(-point.radius));
    picture.proxyMax =
        glm::max(glm::dvec3(context.sceneBounds.max) - point.center, glm::dvec3(point.radius));
    drawn.reflections.push_back(picture);
    s.features |= FEATURE_PROBE;
    const Parallax parallax = context.stage.settings.accuracy.parallax;
    if (parallax == Parallax::box) s.features |= FEATURE_PARALLAX;
    if (parallax == Parallax::depth) s.features |= FEATURE_PARALLAX_DEPTH;
    s.reflection = static_cast<std::uint32_t>(drawn.reflections.size() - 1);
}

}  // namespace

void planCurvedReflections(ViewContext& context, const ViewTask& task, SeenView& seen,
                           DrawScene& drawn) {
    const Stage& stage = context.stage;
    if (!stage.settings.effects.environmentReflection) return;
    const auto reflectors = static_cast<double>(std::count_if(
        seen.surfaces.begin(), seen.surfaces.end(),
        [](const SeenSurface& s) { return s.surface->reflector == Reflector::curved; }));
    for (SeenSurface& s : seen.surfaces) {
        if (s.surface->reflector != Reflector::curved) continue;
        const bool namesMap = !stage.material(*s.surface).environmentMap.empty();
        if (namesMap && reflectStoredMap(context, task, s, drawn)) continue;
        const CapturePoint point = capturePointOf(stage, *s.surface);
        const auto omit = [&](const char* reason) {
            skip(context, task, point.subject, Effect::environmentReflection, reason);
        };
        if (s.share * task.width * task.height < 1.0) {
            omit("smaller than a pixel");
            continue;
        }
        if (skipIfOccluded(context, task, point.subject, Effect::environmentReflection, s.box)) {
            continue;
        }
        const double weight = reflectanceSeen(s.surface->reflectance, 0.5) * s.share;
        if (task.weight * weight < kMinWeight) {
            omit("weight below the visible minimum");
            continue;
        }
        if (task.probeGeneration == 0) continue;  // the environment map
        std::optional<Method> forced =
            requestedMethod(stage.settings.accuracy.curved, Method::probe);
        // The material names a probe, or a blur, which only a cube supports.
        if (point.placed || point.blur.changes()) forced = Method::probe;
        const double noticed = reflectanceSeen(s.surface->reflectance, 0.5) *
                               noticedShare(s.share, stage.settings.accuracy.preset);
        const Method method = chooseMethod(
            context, task, {point.subject, Effect::environmentReflection, s.share, noticed, forced},
            candidatesFor(context, task, s, point, reflectors));
        if (method == Method::traced) s.features |= FEATURE_TRACED_REFLECTION;
        if (method == Method::probe) reflectCapturedCube(context, task, s, point, drawn);
    }
}

void planRoughReflections(const ViewContext& context, const ViewTask& task, SeenView& seen) {
    if (context.stage.settings.accuracy.curvedSamples < 2 || task.captured) return;
    constexpr Features kOther =
        FEATURE_MIRROR | FEATURE_TRACED_REFLECTION | FEATURE_WIDE_LOBE | FEATURE_UNLIT;
    for (SeenSurface& s : seen.surfaces) {
        if (s.features & kOther) continue;
        // The factor is the upper bound of textured roughness.
        if (context.stage.material(*s.surface).roughness > kRoughLobe) {
            s.features |= FEATURE_MAP_SAMPLES;
        }
    }
}

}  // namespace clerestory
