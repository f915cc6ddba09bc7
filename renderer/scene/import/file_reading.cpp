#include "scene/import/file_reading.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace clerestory {

void setHash(FileReading& reading, std::string_view content) {
    const XXH128_hash_t hash = XXH3_128bits(content.data(), content.size());
    reading.outcome = FileReading::Outcome::read;
    reading.low = hash.low64;
    reading.high = hash.high64;
}

}  // namespace clerestory
