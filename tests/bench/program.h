// main() of a benchmark: errors print one line and exit with status 1.
#pragma once

#include <cstdio>
#include <exception>

namespace clerestory::bench {

inline int runProgram(const char* name, int (*run)(int, char**), int argc, char** argv) {
    try {
        return run(argc, argv);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "%s: %s\n", name, e.what());
        return 1;
    }
}

}  // namespace clerestory::bench
