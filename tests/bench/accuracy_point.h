// Time and error of one accuracy setting on one scene for one effect: a row of the curve.
#pragma once

#include "comparison/comparison.h"

#include <optional>
#include <string>
#include <vector>

namespace clerestory::bench {

struct Point {
    std::string scene;
    Effect effect = Effect::base;  // base: the whole frame
    std::string setting;           // nameOf(accuracy)
    std::optional<Preset> preset;  // when it is a preset and no more
    double medianMs = 0.0, p95Ms = 0.0, coldMs = 0.0;
    double processorMs = 0.0;  // of all threads, median; says more on a machine others use, too
    PlanTotals totals;
    double relMse = 0.0;       // on the pixels that the effect carries, as the three that follow
    double relMseNoise = 0.0;  // of the truth
    double relMseOff = 0.0;    // with the effect switched off
    double closedGap = 0.0;
    double frameRelMse = 0.0;           // of the whole frame
    double psnr = 0.0, decibels = 0.0;  // of the whole displayed frame
    double modelDecibels = 0.0;         // of the displayed pixels that show the scene
};
using Points = std::vector<Point>;

// Points of one scene and effect.
struct Curve {
    std::string scene;
    Effect effect = Effect::base;
    Points points;
};

// In the order in which scenes and effects were first seen.
inline std::vector<Curve> curvesOf(const Points& points) {
    std::vector<Curve> curves;
    for (const Point& p : points) {
        auto found = curves.begin();
        while (found != curves.end() && (found->scene != p.scene || found->effect != p.effect)) {
            ++found;
        }
        if (found == curves.end()) found = curves.insert(found, Curve{p.scene, p.effect, {}});
        found->points.push_back(p);
    }
    return curves;
}

inline constexpr Effect kCurveEffects[] = {Effect::base,
                                           Effect::emission,
                                           Effect::refraction,
                                           Effect::planarReflection,
                                           Effect::environmentReflection,
                                           Effect::shadows,
                                           Effect::indirectLight};

// "frame" for the whole frame.
inline std::string curveName(Effect effect) {
    return effect == Effect::base ? "frame" : std::string(nameOf(effect));
}

}  // namespace clerestory::bench
