// The random numbers of one sample of one pixel: Owen-scrambled Sobol points, a fresh pair of
// dimensions for every question (Burley 2020, Practical Hash-based Owen Scrambling). They depend on
// the seed, the pixel and the sample alone, never on a thread.
#pragma once

#include <glm/glm.hpp>

#include <cstdint>

namespace clerestory::reference {

// Every bit of the result hangs on every bit of x (SplitMix64).
inline std::uint64_t mixed(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15ull;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
}

class Random {
public:
    // index: of the sample within `stream`; streams are independent of each other.
    Random(std::uint64_t seed, std::uint64_t stream, std::uint32_t index)
        : key_(mixed(mixed(seed) ^ stream)), index_(index) {}

    // Uniform over [0, 1)^2.
    glm::dvec2 pair() {
        const std::uint64_t key = mixed(key_ + dimension_++);
        const std::uint64_t scrambles = mixed(key);
        const std::uint32_t i = reversed(permuted(reversed(index_), std::uint32_t(key)));
        const std::uint32_t x = reversed(permuted(i, std::uint32_t(scrambles)));
        const std::uint32_t y =
            reversed(permuted(reversed(sobol(i)), std::uint32_t(scrambles >> 32)));
        return {x * 0x1p-32, y * 0x1p-32};
    }
    double one() { return pair().x; }

private:
    static std::uint32_t reversed(std::uint32_t x) {
        x = ((x & 0x55555555u) << 1) | ((x >> 1) & 0x55555555u);
        x = ((x & 0x33333333u) << 2) | ((x >> 2) & 0x33333333u);
        x = ((x & 0x0f0f0f0fu) << 4) | ((x >> 4) & 0x0f0f0f0fu);
        return (x << 24) | ((x & 0xff00u) << 8) | ((x >> 8) & 0xff00u) | (x >> 24);
    }
    // Of bit-reversed numbers: each bit is flipped or not by the bits below it (Laine and Karras
    // 2011).
    static std::uint32_t permuted(std::uint32_t x, std::uint32_t key) {
        x += key;
        x ^= x * 0x6c50b47cu;
        x ^= x * 0xb82f1e52u;
        x ^= x * 0xc7afe638u;
        x ^= x * 0x8d22f6e6u;
        return x;
    }
    // The second dimension of Sobol's sequence; the first is reversed().
    static std::uint32_t sobol(std::uint32_t i) {
        std::uint32_t result = 0;
        for (std::uint32_t v = 1u << 31; i != 0; i >>= 1, v ^= v >> 1) {
            if (i & 1u) result ^= v;
        }
        return result;
    }

    std::uint64_t key_;
    std::uint32_t index_;
    std::uint64_t dimension_ = 0;
};

}  // namespace clerestory::reference
