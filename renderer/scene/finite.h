// Whether all numbers of a value are finite: neither infinite nor NaN.
#pragma once

#include <glm/glm.hpp>

#include <cmath>
#include <concepts>

namespace clerestory {

inline bool finite(std::floating_point auto value) {
    return std::isfinite(value);
}
template <int N, class T>
bool finite(const glm::vec<N, T>& v) {
    for (int i = 0; i < N; ++i) {
        if (!std::isfinite(v[i])) return false;
    }
    return true;
}
template <int C, int R, class T>
bool finite(const glm::mat<C, R, T>& m) {
    for (int i = 0; i < C; ++i) {
        if (!finite(m[i])) return false;
    }
    return true;
}

}  // namespace clerestory
