// What accuracy costs in one scene: a ladder of settings, each with its milliseconds and its error,
// and the choice that a budget makes of them.
#pragma once

#include "comparison/comparison.h"

namespace clerestory {

struct CurvePoint {
    Accuracy accuracy;
    double milliseconds = 0.0;  // median of warm frames of the asked size
    double relMse = 0.0;        // over the frame, against the truth
};

struct Curve {
    std::vector<CurvePoint> points;  // as ladder() has them
    double relMseNoise = 0.0;        // of the truth
};

// The settings that a budget chooses from, from the cheapest to the most exact as a rule; what they
// really cost and show is measured.
std::vector<Accuracy> ladder();

// Traces the truth of a frame with so many paths a pixel; nothing when it was cancelled.
using TraceTruth =
    std::function<std::optional<ReferenceImage>(const FrameRequest& frame, std::uint32_t samples)>;

// Of the whole work; `trace` tells its own progress, below this.
inline constexpr double kCurveTracingShare = 0.3;

// Errors are measured on a smaller picture of the same view (at most 320 texels wide or high), so
// that the truth takes seconds; milliseconds at the frame's own size. Filters are left out of both. `progress` as compare()'s.
// Throws what `trace` and `draw` throw.
std::optional<Curve> measureCurve(const FrameRequest& frame, const TraceTruth& trace,
                                  const DrawFrame& draw,
                                  const std::function<bool(double)>& progress = {});

struct Chosen {
    std::size_t point = 0;  // of the curve
    bool met = true;        // the budget
    std::string words;      // what it is, what was predicted, what was given up
};

// The least error among the points within maxMilliseconds; the cheapest within maxError; with both,
// the cheapest within both. Where none is, the nearest: the cheapest point if time is asked for,
// else the most exact. budget.isBudget(); the curve has points.
Chosen choose(const Curve& curve, const Accuracy& budget);

// A frame of this point took so long: later choices know it.
void refine(CurvePoint& point, double milliseconds);

}  // namespace clerestory
