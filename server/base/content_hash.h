// Hashes of text, for keys and checksums: the same text has the same one in every process and at
// every start. Not against who wants two texts to meet.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace clerestory {

std::uint64_t hashOf(std::string_view text);
// 128 bits as 32 hexadecimal digits.
std::string hashWordOf(std::string_view text);

}  // namespace clerestory
