// What this program is: its version, and the linker's hash of its own bytes.
#pragma once

#include <string>

namespace clerestory {

std::string versionText();  // "0.1.0"

// The GNU build id of the running program in hex; another one after any change to the code. "none"
// when the linker left it out.
std::string buildId();

}  // namespace clerestory
