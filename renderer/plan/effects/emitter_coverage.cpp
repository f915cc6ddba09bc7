#include "plan/effects/emitter_coverage.h"

#include "plan/graph/features.h"

namespace clerestory {
namespace {

// Limits the time of the pass.
constexpr std::uint32_t kMaxTriangles = 20'000;

// As in optics.glsl: more is infinite as a half.
constexpr float kMaxRadiance = 65504.0f;

// Opaque surfaces that emit the same radiance everywhere.
bool isEmitter(const SeenSurface& surface) {
    constexpr Features kVarying = FEATURE_EMISSIVE_MAP | FEATURE_BLEND | FEATURE_MASK;
    return (surface.features & FEATURE_EMISSION) && !(surface.features & kVarying) &&
           surface.primitive == Primitive::triangles && surface.surface->glass == Glass::none;
}

}  // namespace

void planEmitterCoverage(ViewContext& context, const ViewTask& task, const SeenView& seen) {
    const Stage& stage = context.stage;
    if (!stage.settings.accuracy.emitterCoverage || task.captured) return;
    EmitterCoverage work{.view = task.view, .transparent = task.background.coverage};
    std::uint32_t triangles = 0;
    for (const SeenSurface& surface : seen.surfaces) {
        if (!isEmitter(surface)) continue;
        const Material& material = stage.material(*surface.surface);
        const glm::vec3 radiance = glm::min(emittedRadiance(material), glm::vec3(kMaxRadiance));
        for (const SeenCluster& cluster : surface.clusters) {
            triangles += cluster.indexCount / 3;
            if (triangles > kMaxTriangles) break;
            work.emitters.push_back({surface.surface->instance, cluster.firstIndex,
                                     cluster.indexCount, radiance, material.doubleSided});
        }
    }
    if (work.emitters.empty()) return;
    context.builder.addPass(
        {.name = nameOf(task.subject) + ":emitterCoverage",
         .subject = task.subject,
         .effect = Effect::emission,
         .generation = task.generation,
         .target = task.target,
         .reason = "small glowing surfaces by the share that they cover of each pixel",
         .work = std::move(work)});
}

}  // namespace clerestory
