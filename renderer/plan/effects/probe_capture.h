// Cubes captured from a point of the scene: where from, how large, and the passes that draw them.
#pragma once

#include "plan/effects/view_context.h"

#include <optional>

namespace clerestory {

// Where a cube is captured from: the middle of its owner, which it does not show, or a probe that
// was placed in the scene.
struct CapturePoint {
    std::string name;
    glm::dvec3 center{0.0};  // world
    double radius = 0.0;     // of the owner; of a placed probe, half its size; metres
    double znear = 0.0;
    std::optional<double> zfar;
    std::uint32_t resolution = 0;  // texels along a face
    MapBlur blur;
    bool placed = false;
    Index id = 0;                     // the owner's instance, or the index in Scene::probes
    std::vector<std::size_t> hidden;  // surfaces of the stage that the cube does not show
};
CapturePoint capturePointOf(const Stage& stage, const Surface& surface);

// How far the mirror reaches from the cube's centre, 0..1, in radii of the scene; see probeError().
double apartFromCenter(const ViewContext& context, const Surface& surface,
                       const CapturePoint& point);

// The prefiltered cube of that point. In generation k it shows the cubes of generation k - 1. Adds
// its passes unless a cube that is still valid is resident: the key of a cube is the hash of the
// passes that would draw it.
TargetId capturedCube(ViewContext& context, const CapturePoint& point, std::uint32_t generation);

}  // namespace clerestory
