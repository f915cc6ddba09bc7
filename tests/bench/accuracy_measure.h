// Draws one scene with many settings, compares each with one reference, and measures time.
#pragma once

#include "accuracy_point.h"
#include "accuracy_settings.h"

namespace clerestory::bench {

struct MeasureOptions {
    std::uint32_t width = 320, height = 180;
    std::uint32_t samples = 128;  // paths a pixel of the truth
    int rounds = 3;               // settings alternate, so that other load on the machine
    int framesPerRound = 5;       // affects all equally
};

struct Measured {
    Points points;  // of the frame, then of each effect that the view shows; a row a setting
    double truthMs = 0.0;
    std::string renderer;  // as the driver names itself
    bool software = false;
};

// Settings that change nothing here, plan and all, are left out; presets never are. Throws what
// loading and drawing throw.
Measured measureAccuracy(const AccuracyScene& scene, const std::vector<Accuracy>& settings,
                         const MeasureOptions& options);

}  // namespace clerestory::bench
