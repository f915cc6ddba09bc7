// What this program stands on: other people's libraries and their versions, for `--version`.
#pragma once

#include <string>
#include <vector>

namespace clerestory {

struct LibraryVersion {
    std::string name;
    std::string built;  // with
    std::string runs;   // with, now; empty where the library is part of the program or does not say
};

std::vector<LibraryVersion> libraryVersions();

// "clerestory 0.1.0 build ..." and a line for each library.
std::string versionReport();

}  // namespace clerestory
