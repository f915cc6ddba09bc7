// The web page and its files, compiled into the program and served from memory.
#pragma once

#include "server/base/call.h"

#include <optional>

namespace clerestory {

// The file at a path ("/" is the page itself), or nothing.
std::optional<Answer> pageFile(const std::string& path);

}  // namespace clerestory
