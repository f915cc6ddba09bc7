// Shared by the reports of curves: formatted text, and the projection of points for the hull.
#pragma once

#include "accuracy_hull.h"
#include "accuracy_point.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>

namespace clerestory::bench {

#if defined(__GNUC__)
__attribute__((format(printf, 1, 2)))
#endif
inline std::string
text(const char* format, ...) {
    char buffer[512];
    va_list arguments;
    va_start(arguments, format);
    std::vsnprintf(buffer, sizeof buffer, format, arguments);
    va_end(arguments);
    return buffer;
}

// Logarithms need values above 0; half floats do not resolve smaller errors.
inline constexpr double kMinError = 1e-9;
inline double errorFor(const Point& p) {
    return std::max(p.relMse, kMinError);
}

inline std::vector<CostAndError> costsOf(const Points& points) {
    std::vector<CostAndError> costs;
    for (const Point& p : points) costs.push_back({std::max(p.medianMs, 1e-3), errorFor(p)});
    return costs;
}

}  // namespace clerestory::bench
