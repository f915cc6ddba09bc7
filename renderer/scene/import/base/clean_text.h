// Names and messages from files, as they may be shown and logged.
#pragma once

#include <string>

namespace clerestory {

// Valid UTF-8 without control characters, at most 200 bytes. Invalid bytes become '?'.
std::string cleanText(const std::string& text);

}  // namespace clerestory
