// The random numbers of one sample of one pixel: Owen-scrambled Sobol points, a new pair of
// dimensions for each call (Burley 2020, Practical Hash-based Owen Scrambling). They depend on the
// seed, the pixel and the sample index only, not on threads.
#pragma once

#include <glm/glm.hpp>

#include <cstdint>

namespace clerestory::reference {

// Hash in which each bit of the result depends on all bits of x (SplitMix64).
inline std::uint64_t mixBits(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15ull;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
}

class Sampler {
public:
    // index: of the sample within `stream`; streams are independent of each other.
    Sampler(std::uint64_t seed, std::uint64_t stream, std::uint32_t index)
        : key_(mixBits(mixBits(seed) ^ stream)), index_(index) {}

    // Uniform over [0, 1)^2.
    glm::dvec2 get2D() {
        const std::uint64_t key = mixBits(key_ + dimension_++);
        const std::uint64_t scrambles = mixBits(key);
        const std::uint32_t i = reverseBits(owenPermute(reverseBits(index_), std::uint32_t(key)));
        const std::uint32_t x = reverseBits(owenPermute(i, std::uint32_t(scrambles)));
        const std::uint32_t y =
            reverseBits(owenPermute(reverseBits(sobol(i)), std::uint32_t(scrambles >> 32)));
        return {x * 0x1p-32, y * 0x1p-32};
    }
    // Uniform over [0, 1).
    double get1D() { return get2D().x; }

private:
    static std::uint32_t reverseBits(std::uint32_t x) {
        x = ((x & 0x55555555u) << 1) | ((x >> 1) & 0x55555555u);
        x = ((x & 0x33333333u) << 2) | ((x >> 2) & 0x33333333u);
        x = ((x & 0x0f0f0f0fu) << 4) | ((x >> 4) & 0x0f0f0f0fu);
        return (x << 24) | ((x & 0xff00u) << 8) | ((x >> 8) & 0xff00u) | (x >> 24);
    }
    // On bit-reversed numbers: each bit is flipped depending on the bits below it (Laine and Karras
    // 2011).
    static std::uint32_t owenPermute(std::uint32_t x, std::uint32_t key) {
        x += key;
        x ^= x * 0x6c50b47cu;
        x ^= x * 0xb82f1e52u;
        x ^= x * 0xc7afe638u;
        x ^= x * 0x8d22f6e6u;
        return x;
    }
    // The second dimension of the Sobol sequence; the first is reverseBits().
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
