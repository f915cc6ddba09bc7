// Results that a frame can read back in addition to its picture: counts of invalid texels, and the
// pictures that its mirrors show.
#pragma once

#include "image/image.h"
#include "plan/graph/frame_plan.h"

#include <cstdint>
#include <string>
#include <vector>

namespace clerestory {

class Target;

enum class Readback {
    picture,  // the picture only
    health,   // counts of invalid texels of every float target of the plan
    maps,     // the mirrored views and cubes that the requested view reads
};

struct TexelCounts {
    std::uint64_t texels = 0;     // of all levels and faces
    std::uint64_t nonFinite = 0;  // with a NaN or an infinity in a channel
    std::uint64_t negative = 0;   // finite, with a negative channel, in targets that hold light
};

// Reads back and checks all targets: one result for each of plan.targets, all 0 for targets that
// are not float. Slow. Negative values count only where a target holds light, not directions.
std::vector<TexelCounts> countInvalidTexels(const FramePlan& plan,
                                            const std::vector<Target*>& targets);

// A part of a picture, in pixels from its upper left corner; empty without a width.
struct PixelBox {
    std::uint32_t x = 0, y = 0, width = 0, height = 0;
    bool operator==(const PixelBox&) const = default;
};

// What MeasureInstances finds of an instance that is in the frame, or would be if it were alone.
struct InstanceExtent {
    Index instance = 0;
    std::uint32_t pixels = 0, pixelsAlone = 0;  // that show it; that would if it were alone
    PixelBox box, boxAlone;                     // of these pixels
};

struct MapPicture {
    std::string target;  // its name in the plan
    // float32, 3 channels, linear radiance. Of a flat mirror: its mirrored view. Of a cube: its six
    // faces, +X -X +Y in the first row and -Y +Z -Z in the second, in OpenGL's orientation.
    Image picture;
};

// One for every mirrored view and every cube that the requested view reads, in that order; cubes at
// the first level of at most 256 texels per edge. Call it after the plan was executed.
std::vector<MapPicture> mapPictures(const FramePlan& plan, const std::vector<Target*>& targets);

}  // namespace clerestory
