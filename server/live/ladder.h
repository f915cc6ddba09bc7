// The ladder of a live frame: smaller and cheaper versions of a request, for frames in motion.
//
//     const Ladder ladder = ladderOf(request);
//     const FrameRequest small = atLevel(request, ladder.levels.back());
//
// Level 0 is the request itself. Below it are three quarters and half of its edges; half with the
// preset draft; then three eighths, a quarter, three sixteenths and an eighth with draft. Requests
// of draft have each size once, and requests of an accuracy budget use draft below level 0, since
// each size would need a curve of its own. Levels below 160 x 90 pixels are left out.
#pragma once

#include "plan/request/frame_request.h"

#include <cstdint>
#include <vector>

namespace clerestory {

struct Level {
    double scale = 1.0;  // of the edges, (0, 1]
    bool draft = false;  // with the preset draft instead of the accuracy of the request
    // Expected time relative to level 0, without the part that does not depend on pixels.
    double cost() const { return scale * scale * (draft ? 0.6 : 1.0); }
    bool operator==(const Level&) const = default;
};

struct Ladder {
    std::vector<Level> levels;  // at least one; each costs less than the one before
    // Of requests whose frames take about the same time.
    std::uint32_t width = 0, height = 0;
    bool operator==(const Ladder&) const = default;
};
Ladder ladderOf(const FrameRequest& request);

// The same picture at that level: intrinsics and the lengths of filters in pixels are scaled.
FrameRequest atLevel(const FrameRequest& request, const Level& level);

}  // namespace clerestory
