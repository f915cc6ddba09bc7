// Whether a scene's surfaces can hide anything from each other.
//
//     if (isConvex(scene, restPose(scene))) ... // neither shadows nor light between surfaces
#pragma once

#include "scene/scene.h"

namespace clerestory {

// True if no point of a surface faces another surface: all triangles lie behind the plane of each
// one-sided triangle, and in the plane of each two-sided one. Also false for scenes that deform or
// whose instances move relative to each other, and if more than about 20 million comparisons would
// be needed. The search ends at the first surface in front of another.
bool isConvex(const Scene& scene, const Pose& pose);

}  // namespace clerestory
