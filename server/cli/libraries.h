// Third-party libraries and their versions, for `--version`.
#pragma once

#include <string>
#include <vector>

namespace clerestory {

struct LibraryVersion {
    std::string name;
    std::string built;  // version at compile time
    std::string runs;   // version at run time; empty if it is linked statically or unknown
};

std::vector<LibraryVersion> libraryVersions();

// "clerestory 0.1.0 build ..." and a line for each library.
std::string versionReport();

}  // namespace clerestory
