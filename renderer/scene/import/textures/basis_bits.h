// The bit stream and the Huffman codes of BasisLZ: KTX File Format Specification 2.0,
// "BasisLZ/ETC1S Bitstream Specification".
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clerestory {

// Throws ImportError: the texture is damaged.
[[noreturn]] void damagedBasis(const char* what);

// A little-endian number of up to 8 bytes, and a part. Throw ImportError outside of `bytes`.
std::uint64_t numberIn(std::span<const unsigned char> bytes, std::uint64_t at, std::size_t size);
std::span<const unsigned char> partOf(std::span<const unsigned char> bytes, std::uint64_t at,
                                      std::uint64_t size);

// Reads fields from the least significant bit of each byte upwards. Throws ImportError at the end.
class BasisBits {
public:
    explicit BasisBits(std::span<const unsigned char> bytes) : bytes_(bytes) {}

    std::uint32_t bit() {
        if (at_ >= 8 * bytes_.size()) damagedBasis("a part of it ends early");
        const std::uint32_t value = bytes_[at_ / 8] >> at_ % 8 & 1u;
        ++at_;
        return value;
    }
    std::uint32_t take(std::uint32_t count);  // up to 32
    // Chunks of this many bits, each followed by a bit that is 1 if another one follows.
    std::uint32_t takeChunks(std::uint32_t bitsOfChunk);

private:
    std::span<const unsigned char> bytes_;
    std::size_t at_ = 0;
};

// A canonical prefix code, which is stored as the lengths of its codes.
class BasisHuffman {
public:
    BasisHuffman() = default;  // without symbols
    // Reads the table. Throws ImportError if it is none.
    explicit BasisHuffman(BasisBits& bits);

    // Throws ImportError if no code matches.
    std::uint32_t symbol(BasisBits& bits) const;

private:
    static constexpr std::uint32_t kMaxLength = 16;
    explicit BasisHuffman(std::span<const std::uint8_t> lengths);

    std::array<std::uint32_t, kMaxLength + 1> codesOf_{};  // number of codes by length
    std::vector<std::uint16_t> symbols_;                   // ordered by code
};

}  // namespace clerestory
