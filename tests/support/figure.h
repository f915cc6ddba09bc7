// One figure of the failure catalogue.
#pragma once

#include <string>

namespace clerestory::test {

struct Figure {
    std::string row;   // of the catalogue, as "C1"
    std::string what;  // was done, in words
    std::string figure;
    std::string bar;
    bool held = false;   // statuses and counts
    bool timely = true;  // the times
};

}  // namespace clerestory::test
