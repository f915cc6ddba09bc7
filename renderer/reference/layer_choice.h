// Chooses one of the layers of an opaque surface, as KHR_materials_clearcoat, _sheen and
// _diffuse_transmission define them.
//
//     chooseLayer(point, toEye, sampler, throughput);  // point is one of its layers now
//     const Bsdf bsdf(point, toEye);
#pragma once

#include "reference/sampler.h"
#include "reference/scene_geometry.h"

#include <glm/glm.hpp>

namespace clerestory::reference {

// Changes `point` into one of its layers, chosen at random, and multiplies `throughput` by the
// layer's share over its probability. toEye: unit.
void chooseLayer(SurfaceInteraction& point, const glm::dvec3& toEye, Sampler& sampler,
                 glm::dvec3& throughput);

// What a coat leaves of light that is emitted below it.
double belowClearcoat(const SurfaceInteraction& point, const glm::dvec3& toEye);

}  // namespace clerestory::reference
