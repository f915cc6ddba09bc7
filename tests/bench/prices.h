// The prices of the cost model, measured on small scenes that are made for them.
#pragma once

#include "renderer.h"

#include <string>
#include <vector>

namespace clerestory::bench {

struct Price {
    std::string name;
    double measured = 0.0;
    double compiledIn = 0.0;  // 0: the cost model has no such constant
    const char* unit = "";
};

// Every constant of the driver that Renderer finds, and the shading of a pixel by variant. rounds:
// frames per measurement, of which the fastest counts.
std::vector<Price> measurePrices(int rounds);

}  // namespace clerestory::bench
