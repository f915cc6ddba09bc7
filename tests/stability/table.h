// The stability table: the row of each case, and its figure relative to the bound. At the end a
// program prints its rows: cases, worst figure, bound.
#pragma once

#include <gtest/gtest.h>

#include <string_view>

namespace clerestory::test {

// Counts a case; true when it is a number and at most, or at least, its bound. The worst figure of
// a row is the one nearest to its bound, or farthest beyond. what: the figure, with its unit.
::testing::AssertionResult atMost(std::string_view row, std::string_view what, double figure,
                                  double bound);
::testing::AssertionResult atLeast(std::string_view row, std::string_view what, double figure,
                                   double bound);

bool longForm();
// Steps of a sweep.
inline int steps(int ofShort, int ofLong) {
    return longForm() ? ofLong : ofShort;
}

}  // namespace clerestory::test
