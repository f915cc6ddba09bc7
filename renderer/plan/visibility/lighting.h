// Which lights a frame has, and which of them reach a given draw.
#pragma once

#include "plan/graph/frame_plan.h"

namespace clerestory {

// The scene's lights placed in the world, then the environment's sun. At most kMaxLights; lights
// that give nothing are left out.
std::vector<PlacedLight> placedLights(const Scene& scene, const Pose& pose,
                                      const EnvironmentMap& environment,
                                      const glm::dmat3& worldFromMap, float environmentIntensity);

// The lights that can reach a box (relative to the eye, world axes), the strongest
// kMaxLightsPerDraw of them, in the order of `lights`. `reaching` counts all that could.
LightList lightsReaching(const std::vector<PlacedLight>& lights, const glm::dvec3& eye,
                         const Bounds& box, std::uint32_t& reaching);

// All of them, however many.
std::vector<std::uint8_t> allLightsReaching(const std::vector<PlacedLight>& lights,
                                            const glm::dvec3& eye, const Bounds& box);

}  // namespace clerestory
