// Figures with their limits as rows of a Markdown table. Printed by scripts/attack, chaos, soak and
// fuzz; collected by scripts/reliability.
#pragma once

#include "tests/bench/statistics.h"
#include "tests/support/figure.h"

#include <cstdio>
#include <vector>

namespace clerestory::bench {

class Bars {
public:
    Bars() { std::printf("| row | what | figure | bar | |\n|---|---|---|---|---|\n"); }
    void add(const test::Figure& f) {
        const bool held = f.held && f.timely;
        std::printf("| %s | %s | %s | %s | %s |\n", f.row.c_str(), f.what.c_str(), f.figure.c_str(),
                    f.bar.c_str(), held ? "held" : "MISSED");
        std::fflush(stdout);
        missed_ += !held;
    }
    void add(const std::vector<test::Figure>& figures) {
        for (const test::Figure& figure : figures) add(figure);
    }
    // Says how many were missed; the exit status.
    int end() const {
        std::printf("\n%d missed; load average %.1f\n", missed_, loadAverage());
        return missed_ == 0 ? 0 : 1;
    }

private:
    int missed_ = 0;
};

}  // namespace clerestory::bench
