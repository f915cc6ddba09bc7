// Recorded errors that later measurements must not exceed.
#pragma once

#include "accuracy_point.h"

namespace clerestory::bench {

inline constexpr double kMaxGrowth = 1.05;

// The file's text: a comment that names the driver, then scene, effect, setting, relMse.
std::string recordOf(const Points& points, const std::string& renderer);

struct Held {
    int held = 0, missing = 0;          // rows compared; points that the record lacks
    std::vector<std::string> exceeded;  // one line each
};
// Throws std::runtime_error when the record cannot be read.
Held heldAgainst(const std::string& record, const Points& points);

}  // namespace clerestory::bench
