// The light of surfaces that nothing hides the environment from: what a frame shows until the first
// round of its light is computed (bake.h). It has the form of computed light, so that frames before
// and after have the same programs.
//
//     const SurfaceLight light = openLight({.scene = scene, .pose = *pose, ...});
//
// Pure; takes time in proportion to the vertices, about 10 ms for 200,000.
#pragma once

#include "light/surface_light.h"
#include "plan/graph/draw.h"
#include "scene/environment.h"

namespace clerestory::light {

// Of every vertex of a surface in the open: the mean irradiance, and how that changes with the
// normal.
LightAtVertex lightInTheOpen(const EnvironmentMap& environment, float intensity);

struct OpenLightInput {
    std::shared_ptr<const Scene> scene;  // as it is, not refined
    const Pose& pose;
    const MaterialBindings& materials;
    const EnvironmentMap& environment;
    glm::dmat3 mapFromWorld{1.0};
    float environmentIntensity = 1.0f;
    bool emitters = false;  // as BakeInput::emitters
    std::uint64_t key = 0;  // of the light that will follow
};
// Revision 0. At vertices the irradiance is that of the nine harmonics of the map.
SurfaceLight openLight(const OpenLightInput& input);

}  // namespace clerestory::light
