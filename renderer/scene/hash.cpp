#include "scene/hash.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <cstdio>
#include <new>

namespace clerestory {
namespace {

XXH3_state_t& xxh3(std::byte* state) {
    return *std::launder(reinterpret_cast<XXH3_state_t*>(state));
}
const XXH3_state_t& xxh3(const std::byte* state) {
    return *std::launder(reinterpret_cast<const XXH3_state_t*>(state));
}

}  // namespace

std::uint64_t hashOfBytes(std::span<const std::byte> bytes, std::uint64_t seed) {
    return XXH3_64bits_withSeed(bytes.data(), bytes.size(), seed);
}

Hash128 hash128OfBytes(std::span<const std::byte> bytes) {
    const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
    return {hash.low64, hash.high64};
}

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

ContentHash::ContentHash() {
    static_assert(sizeof(XXH3_state_t) <= kStateBytes && alignof(XXH3_state_t) <= 64);
    new (state_) XXH3_state_t{};
    XXH3_64bits_reset(&xxh3(state_));
}

void ContentHash::addBytes(const void* bytes, std::size_t count) {
    XXH3_64bits_update(&xxh3(state_), bytes, count);
}

std::uint64_t ContentHash::value() const {
    return XXH3_64bits_digest(&xxh3(state_));
}

}  // namespace clerestory
