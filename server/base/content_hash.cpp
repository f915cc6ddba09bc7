#include "server/base/content_hash.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <cstdio>

namespace clerestory {

std::uint64_t hashOf(std::string_view text) {
    return XXH3_64bits(text.data(), text.size());
}

std::string hashWordOf(std::string_view text) {
    const XXH128_hash_t hash = XXH3_128bits(text.data(), text.size());
    char word[33];
    std::snprintf(word, sizeof word, "%016llx%016llx", static_cast<unsigned long long>(hash.high64),
                  static_cast<unsigned long long>(hash.low64));
    return word;
}

}  // namespace clerestory
