// Effect: light between surfaces (Effects::indirectLight). Decides whether a frame needs it and
// what it depends on; renderer/light computes it, and surfaces show it (light/surface_light.h).
//
//     const LightInputs inputs = lightInputs(context, request);
//     if (inputs.unneeded.empty()) ... // inputs.hash identifies the light
#pragma once

#include "plan/graph/frame_context.h"
#include "plan/graph/frame_plan.h"
#include "plan/request/frame_request.h"

#include <cstdint>
#include <string>
#include <vector>

namespace clerestory {

// Whether frames of the request may show it; other channels than colour do not.
inline bool showsSurfaceLight(const FrameRequest& request) {
    return request.effects.indirectLight && request.output.channel == Channel::color;
}

// What the light of surfaces depends on (light/bake.h), apart from the scene and the map.
struct LightInputs {
    std::vector<PlacedLight> lights;  // that do not move
    std::size_t movingLights = 0;     // left out: they light surfaces, but no light goes further
    MaterialBindings materials;
    glm::dmat3 mapFromWorld{1.0};
    float environmentIntensity = 1.0f;
    bool emission = true;
    bool emitters = false;   // surfaces emit
    std::uint64_t hash = 0;  // of everything, the scene and the map included
    // Why surfaces would show the same without it, without a full stop; else empty.
    std::string unneeded;
};
// Throws InvalidRequest if problems(request) is not empty.
LightInputs lightInputs(const FrameContext& context, const FrameRequest& request);

// Sets the light of the plan of a colour frame, or adds why it has none. Nothing changes if the
// request has the effect switched off.
void planSurfaceLight(FramePlan& plan, const FrameContext& context, const FrameRequest& request);

}  // namespace clerestory
