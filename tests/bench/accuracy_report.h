// Curves as data, Markdown and diagrams.
#pragma once

#include "accuracy_point.h"

namespace clerestory::bench {

// The clock behind the milliseconds of tables and diagrams. On a shared machine, processor
// time of all threads is more meaningful than wall clock time.
enum class Clock { wall, processor };
const char* words(Clock clock);

// curvesOf(points) with that clock's milliseconds as medianMs.
std::vector<Curve> curvesBy(const Points& points, Clock clock);

std::string csvOf(const Points& points);  // both clocks

// The settings on the hull of each scene and effect, cheapest first, and the presets off it with
// the setting that is better in both error and time.
std::string hullCsvOf(const Points& points, Clock clock = Clock::wall);

// Geometric means over the scenes of each setting's error and time, as multiples of standard's.
std::string settingsCsvOf(const Points& points, Clock clock = Clock::wall);

// The presets by scene and effect, what lies on the hulls, presets that are off them, and what each
// knob does on average.
std::string markdownOf(const Points& points, Clock clock = Clock::wall);

// A panel a scene of one effect: milliseconds against error, both logarithmic. Self-contained SVG;
// empty when no scene shows the effect.
std::string svgOf(const Points& points, Effect effect, Clock clock = Clock::wall);

// More than this worse in both, and a setting is off the hull.
inline constexpr double kOffHull = 0.05;

}  // namespace clerestory::bench
