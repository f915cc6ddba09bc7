// Hashes of text for keys and checksums, equal in all processes. Not cryptographic: collisions can
// be constructed.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace clerestory {

std::uint64_t hashOf(std::string_view text);
// 128 bits as 32 hexadecimal digits.
std::string hashWordOf(std::string_view text);

}  // namespace clerestory
