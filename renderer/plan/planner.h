// Plans a frame: scene, request and resident maps -> FramePlan. Pure; needs no OpenGL.
#pragma once

#include "plan/graph/frame_context.h"
#include "plan/graph/frame_plan.h"
#include "scene/scene.h"

namespace clerestory {

// The error for a request that names a clip that the scene does not have; lists those that it has.
FieldError unknownClip(const Scene& scene);
FieldError unknownVariant(const Scene& scene);
// Whether it is absent or a variant of the scene.
bool hasVariant(const Scene& scene, const std::optional<std::string>& name);

// Equal arguments give equal plans.
//
//     FramePlan plan = planFrame({.scene = scene, .pose = pose, ...}, request);
//
// Throws InvalidRequest if problems(request) is not empty, or if the request names a camera that
// the scene does not have.
// What the light of surfaces depends on (light/bake.h), apart from the scene and the map.
struct LightInputs {
    std::vector<PlacedLight> lights;
    MaterialBindings materials;
    glm::dmat3 mapFromWorld{1.0};
    float environmentIntensity = 1.0f;
    bool emission = true;
    std::uint64_t hash = 0;  // of everything, the scene and the map included
};
// Throws InvalidRequest as planFrame() does.
LightInputs lightInputs(const FrameContext& context, const FrameRequest& request);

FramePlan planFrame(const FrameContext& context, const FrameRequest& request);

}  // namespace clerestory
