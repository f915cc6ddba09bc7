// The lower hull of settings (milliseconds against error), and the settings above it.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace clerestory::bench {

struct CostAndError {
    double milliseconds = 0.0, error = 0.0;  // both above 0
};

// The corners of the lower left of the convex hull in logarithms of both, from the cheapest point
// to the one with the least error; indices into `points`.
std::vector<std::size_t> lowerHull(const std::vector<CostAndError>& points);

// A point that is better than points[index] in both by more than `share`; the one with the least
// error of those, or none.
std::optional<std::size_t> betterInBoth(const std::vector<CostAndError>& points, std::size_t index,
                                        double share);

}  // namespace clerestory::bench
