// Fuzz targets as functions of bytes: for libFuzzer, and for the test suite with a fixed list of
// mutations. They abort if an invariant is violated.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string>
#include <vector>

namespace clerestory::test {

using Bytes = std::span<const std::uint8_t>;

inline void require(bool holds, const char* words) {
    if (holds) return;
    std::fprintf(stderr, "does not hold: %s\n", words);
    std::abort();
}

// The guard and the library behind it, over an writer in memory: however a request is cut into
// pieces, it is understood in the same way, within the limits, and answered once.
void fuzzHttp(Bytes bytes);
// The JSON reader: a checked request or a refusal in plain words, never another exception.
void fuzzJson(Bytes bytes);

// The bytes between the header and the checksum of a scene's blob: a valid scene, a scene with
// problems, or a rejection.
void fuzzBlob(Bytes bytes);

// A decoder of compressed files: "webp", "avif", "ktx2", "meshopt" or "draco". Decoded content of
// the declared size, or a refusal with a reason.
void (*codecTarget(const std::string& codec))(Bytes);
std::vector<std::string> codecSeeds(const std::string& codec);

// Seeds for mutations; random bytes would rarely reach the same code.
std::vector<std::string> httpSeeds();
std::vector<std::string> jsonSeeds();
std::vector<std::string> blobSeeds();

}  // namespace clerestory::test
