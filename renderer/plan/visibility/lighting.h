// The lights of a frame, and those that reach a box. Light indices refer to FramePlan::lights.
#pragma once

#include "plan/graph/frame_plan.h"

namespace clerestory {

// The lights of the scene in world space, then the sun of the environment. At most kMaxLights;
// lights of zero intensity are left out.
std::vector<PlacedLight> placedLights(const std::vector<Light>& lights, const Pose& pose,
                                      const EnvironmentMap& environment,
                                      const glm::dmat3& worldFromMap, float environmentIntensity);

// The strongest kMaxLightsPerDraw lights that can reach the box (relative to the eye, world axes),
// in the order of `lights`. `reaching` receives the number of all lights that can reach it.
LightList lightsReaching(const std::vector<PlacedLight>& lights, const glm::dvec3& eye,
                         const Bounds& box, std::uint32_t& reaching);

// All lights that can reach the box, without a limit.
std::vector<std::uint8_t> allLightsReaching(const std::vector<PlacedLight>& lights,
                                            const glm::dvec3& eye, const Bounds& box);

// Estimated mean irradiance of the brightest channel in the box (world axes, relative to `eye`),
// for surfaces that face the light; 0 if it cannot reach the box.
double meanIrradiance(const PlacedLight& light, const glm::dvec3& eye, const Bounds& box);

}  // namespace clerestory
