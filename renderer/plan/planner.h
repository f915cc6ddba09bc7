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
FramePlan planFrame(const FrameContext& context, const FrameRequest& request);

}  // namespace clerestory
