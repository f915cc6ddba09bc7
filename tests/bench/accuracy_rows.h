// Reads curves of earlier measurements from CSV.
#pragma once

#include "accuracy_point.h"

namespace clerestory::bench {

// What csvOf() wrote. Throws std::runtime_error for a row that is short or has no number where one
// belongs.
Points pointsFrom(const std::string& csv);

}  // namespace clerestory::bench
