// The pictures that a frame's mirrors look at, taken away as linear light: for people who want to
// see why a reflection looks as it does.
#pragma once

#include "image/image.h"
#include "passes/targets.h"
#include "plan/graph/frame_plan.h"

#include <string>
#include <vector>

namespace clerestory {

struct MapPicture {
    std::string target;  // its name in the plan
    // float32, 3 channels, linear radiance. A flat mirror's is its part of the view as the mirrored
    // eye sees it; a cube's is its six faces, +X -X +Y above -Y +Z -Z, each as OpenGL keeps it.
    Image picture;
};

// Of every mirrored view and every cube that the requested view itself reads, in its order; cubes
// at the first level of at most 256 texels an edge. To be called after the plan has run.
std::vector<MapPicture> mapPictures(const FramePlan& plan, const std::vector<Target*>& targets);

}  // namespace clerestory
