// Curves as data, as Markdown and as pictures.
#pragma once

#include "accuracy_point.h"

namespace clerestory::bench {

std::string csvOf(const Points& points);

// The presets by scene and effect, what lies on the hulls, presets that are off them, and what each
// knob does on average.
std::string markdownOf(const Points& points);

// A panel a scene of one effect: milliseconds against error, both logarithmic. Self-contained SVG;
// empty when no scene shows the effect.
std::string svgOf(const Points& points, Effect effect);

// More than this worse in both, and a setting is off the hull.
inline constexpr double kOffHull = 0.05;

}  // namespace clerestory::bench
