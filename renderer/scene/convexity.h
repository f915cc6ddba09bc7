// Whether a scene's surfaces can hide anything from each other.
//
//     if (isConvex(scene, restPose(scene))) ... // neither shadows nor light between surfaces
#pragma once

#include "scene/scene.h"

namespace clerestory {

// True if no point of a surface sees another surface: every triangle has all others behind it, and
// a triangle with two sides all others in its plane. False as well for scenes that deform, whose
// instances move against each other, and that would need more than some 20 million comparisons; the
// first surface that lies in front of another ends the search.
bool isConvex(const Scene& scene, const Pose& pose);

}  // namespace clerestory
