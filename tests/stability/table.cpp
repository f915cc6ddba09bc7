#include "tests/stability/table.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace clerestory::test {
namespace {

struct Line {
    std::string row, what;
    bool most = true;
    std::size_t cases = 0, failed = 0;
    double worst = 0.0, bound = 0.0;
};
std::vector<Line>& lines() {
    static std::vector<Line> all;  // in the order in which rows were met
    return all;
}

Line& lineOf(std::string_view row, std::string_view what, bool most) {
    for (Line& line : lines()) {
        if (line.row == row && line.what == what) return line;
    }
    lines().push_back({.row = std::string(row), .what = std::string(what), .most = most});
    return lines().back();
}

// Above 1 beyond the bound; of bounds of 0 any excess is infinitely far beyond.
double badness(const Line& line, double figure, double bound) {
    if (std::isnan(figure)) return HUGE_VAL;
    const double over = line.most ? figure : bound;
    const double under = line.most ? bound : figure;
    if (under > 0.0) return over / under;
    return over > under ? HUGE_VAL : over <= 0.0 ? 0.0 : 1.0;
}

::testing::AssertionResult judged(std::string_view row, std::string_view what, double figure,
                                  double bound, bool most) {
    Line& line = lineOf(row, what, most);
    const bool held = most ? figure <= bound : figure >= bound;  // false for NaN
    if (line.cases == 0 || badness(line, figure, bound) > badness(line, line.worst, line.bound)) {
        line.worst = figure;
        line.bound = bound;
    }
    ++line.cases;
    if (held) return ::testing::AssertionSuccess();
    ++line.failed;
    return ::testing::AssertionFailure() << row << ": " << what << " is " << figure << ", not "
                                         << (most ? "<= " : ">= ") << bound << ' ';
}

class Summary : public ::testing::Environment {
    void TearDown() override {
        std::printf("\n%-22s %-44s %8s %12s %14s\n", "row", "figure", "cases", "worst", "bound");
        for (const Line& line : lines()) {
            std::printf("%-22s %-44s %8zu %12.4g %2s %11.4g", line.row.c_str(), line.what.c_str(),
                        line.cases, line.worst, line.most ? "<=" : ">=", line.bound);
            if (line.failed > 0) std::printf("  %zu FAILED", line.failed);
            std::printf("\n");
        }
        std::fflush(stdout);
    }
};
// Owned by GoogleTest.
[[maybe_unused]] ::testing::Environment* const summary =
    ::testing::AddGlobalTestEnvironment(new Summary);

}  // namespace

::testing::AssertionResult atMost(std::string_view row, std::string_view what, double figure,
                                  double bound) {
    return judged(row, what, figure, bound, true);
}
::testing::AssertionResult atLeast(std::string_view row, std::string_view what, double figure,
                                   double bound) {
    return judged(row, what, figure, bound, false);
}

bool longForm() {
    const char* asked = std::getenv("CLERESTORY_STABILITY");
    return asked && std::string_view(asked) == "long";
}

}  // namespace clerestory::test
