// Reads curves of earlier measurements from CSV.
#pragma once

#include "accuracy_point.h"

namespace clerestory::bench {

// Reads the output of csvOf(). Throws std::runtime_error for a row with missing fields or invalid
// numbers.
Points pointsFrom(const std::string& csv);

}  // namespace clerestory::bench
