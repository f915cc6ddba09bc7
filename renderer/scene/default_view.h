// The view of a request without a camera.
//
//     scene.defaultView = chosenView(scene);   // by the importer: it reads every triangle
//     const DefaultView view = defaultView(scene);
//     camera.yfov = fieldOfView(view, aspect);
#pragma once

#include "scene/scene.h"

namespace clerestory {

// The share of the frame, along its narrower margin, that a fitted view fills.
inline constexpr double kFittedShare = 0.8;

// Scene::defaultView; chosenView() in a scene without one.
DefaultView defaultView(const Scene& scene);

// The first perspective camera that sees a surface, and a quarter of all corners if it stands
// outside of the scene's box, else fittedView(). Takes time in proportion to the triangles.
DefaultView chosenView(const Scene& scene);

// From the front, the right and slightly above, so that the surfaces, as they are at time 0 and at
// other times of the default clips, fill kFittedShare of the frame. A few corners that lie far away
// from all others (errors of exporters) are left out. `most`: maximum number of corners that are
// used; of more, evenly spaced ones.
DefaultView fittedView(const Scene& scene, std::size_t most = 4'000'000);

// The view's vertical field of view in a frame of this width / height, radians. A fitted view
// changes it so that the surfaces fill the same share of frames of every shape.
double fieldOfView(const DefaultView& view, double aspect);

// How much of a square frame shows surfaces, whichever side they turn to the eye: in [0, 1], by
// 32 x 32 samples.
double coveredShare(const Scene& scene, const Pose& pose, const DefaultView& view);

}  // namespace clerestory
