// The initial corpus for libFuzzer.
#pragma once

#include <fstream>
#include <string>
#include <vector>

namespace clerestory::test {

// Into the folder of the corpus, which is the last word of the command line.
inline void plant(const std::vector<std::string>& seeds, const std::string& folder) {
    for (std::size_t i = 0; i < seeds.size(); ++i) {
        std::ofstream(folder + "/seed" + std::to_string(i), std::ios::binary) << seeds[i];
    }
}

}  // namespace clerestory::test
