// The trade-off between time and error in one scene: settings of increasing cost with measured
// milliseconds and errors, and the choice of a setting for a budget.
#pragma once

#include "comparison/comparison.h"

namespace clerestory {

struct CurvePoint {
    Accuracy accuracy;
    double milliseconds = 0.0;  // median of warm frames of the requested size
    double relMse = 0.0;        // over the frame, against the reference
};

struct Curve {
    std::vector<CurvePoint> points;  // in the order of curveSettings()
    double relMseNoise = 0.0;        // of the reference
};

// The settings that a budget chooses from, roughly from the cheapest to the most exact.
std::vector<Accuracy> curveSettings();

// Traces the reference of a frame with `samples` paths per pixel; returns nothing if cancelled.
using TraceTruth =
    std::function<std::optional<ReferenceImage>(const FrameRequest& frame, std::uint32_t samples)>;

// Fraction of the total work; `trace` reports its own progress below this.
inline constexpr double kCurveTracingShare = 0.3;

// Errors are measured on a smaller image of the same view (at most 320 pixels wide or high), so
// that tracing takes seconds; milliseconds at the requested size. Both without filters. `progress`
// as for compare(). Passes on exceptions of `trace` and `draw`.
std::optional<Curve> measureCurve(const FrameRequest& frame, const TraceTruth& trace,
                                  const DrawFrame& draw,
                                  const std::function<bool(double)>& progress = {});

struct Chosen {
    std::size_t point = 0;  // of the curve
    bool met = true;        // the budget
    std::string words;      // the setting, its prediction, and the best setting that was not chosen
};

// The least error within maxMilliseconds; the cheapest within maxError; with both bounds, the
// cheapest within both. If no point meets the budget: the cheapest point if maxMilliseconds is set,
// else the most exact. Requires budget.isBudget() and a nonempty curve.
Chosen choose(const Curve& curve, const Accuracy& budget);

// Updates the point's time with the measured time of a frame.
void refine(CurvePoint& point, double milliseconds);

}  // namespace clerestory
