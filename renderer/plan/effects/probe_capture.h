// Captured cubes: position, size, passes and residency.
#pragma once

#include "plan/effects/view_context.h"

#include <optional>

namespace clerestory {

// Position and parameters of a captured cube: the centre of its owner, which the cube does not
// show, or a probe that the scene defines.
struct CapturePoint {
    Subject subject;
    glm::dvec3 center{0.0};  // world
    double radius = 0.0;     // metres; of the owner, or half the size of a placed probe
    double znear = 0.0;      // metres
    std::optional<double> zfar;
    std::uint32_t resolution = 0;  // texels along an edge of a face
    MapBlur blur;
    bool placed = false;              // a probe of the scene
    Index id = 0;                     // index of Scene::probes, or the owner's instance
    std::vector<std::size_t> hidden;  // omitted surfaces, indices of Stage::surfaces; sorted
};
// The capture point of a curved mirror.
CapturePoint capturePointOf(const Stage& stage, const Surface& surface);

// How far the surface of a mirror is from its cube's centre, 0..1; see probeError().
double apartFromCenter(const ViewContext& context, const Surface& surface,
                       const CapturePoint& point);

// Returns the prefiltered cube of the point. In generation k it shows the cubes of generation k
// - 1. Adds its passes unless a valid cube is resident: the key of a cube is the hash of the passes
// that draw it.
TargetId capturedCube(ViewContext& context, const CapturePoint& point, std::uint32_t generation);

}  // namespace clerestory
