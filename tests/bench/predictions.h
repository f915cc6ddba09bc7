// The planner's predicted errors of each technique, and the measured ones.
#pragma once

#include "comparison/comparison.h"

#include <span>

namespace clerestory::bench {

// A technique of an effect, and the setting that requests it.
struct Technique {
    Effect effect;
    Method method;
    void (*request)(Accuracy&);
};
std::span<const Technique> techniques();

struct Prediction {
    Effect effect = Effect::base;
    Method method = Method::environment;
    double predicted = 0.0;  // relative RMSE, of the effect's surfaces in view by their share
    double measured = 0.0;   // the same against the truth, on the effect's pixels
    double noise = 0.0;      // of the truth, likewise
};

// Every way of every effect that the frame's view offers a choice for, each served that way where
// it can be, all else as the frame asks. `draw` plans and draws.
std::vector<Prediction> measurePredictions(const FrameRequest& frame, const ReferenceImage& truth,
                                           const DrawFrame& draw);

struct Agreement {
    int pairs = 0;                      // of ways of one effect with distinct expectations
    std::vector<std::string> reversed;  // a line for each pair that is the other way round
};
// Pairs whose expected errors are farther apart than 1.25 times are expected to be in that order;
// measured ones within 1.05 times, or within twice the noise, are in any.
Agreement agreementOf(const std::vector<Prediction>& predictions);

// A Markdown table with the ratios, their median and the worst, and the order.
std::string textOf(const std::vector<Prediction>& predictions);

}  // namespace clerestory::bench
