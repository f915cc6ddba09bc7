// Version and build id of this program.
#pragma once

#include <string>

namespace clerestory {

std::string versionText();  // "0.1.0"

// The GNU build id of the running program in hex, a hash of its code; "none" if the linker did not
// write one.
std::string buildId();

}  // namespace clerestory
