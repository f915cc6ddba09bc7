#include "scene/import/textures/basis_bits.h"

#include "scene/import/base/types.h"

#include <string>

namespace clerestory {

void damagedBasis(const char* what) {
    throw ImportError(ImportError::Reason::malformed,
                      std::string("the KTX2 texture is damaged: ") + what);
}

std::uint64_t numberIn(std::span<const unsigned char> bytes, std::uint64_t at, std::size_t size) {
    if (at > bytes.size() || size > bytes.size() - at) damagedBasis("its header ends early");
    std::uint64_t value = 0;
    for (std::size_t i = size; i-- > 0;) value = value << 8 | bytes[at + i];
    return value;
}

std::span<const unsigned char> partOf(std::span<const unsigned char> bytes, std::uint64_t at,
                                      std::uint64_t size) {
    if (at > bytes.size() || size > bytes.size() - at) damagedBasis("a part of it is missing");
    return bytes.subspan(at, size);
}

std::uint32_t BasisBits::take(std::uint32_t count) {
    std::uint32_t value = 0;
    for (std::uint32_t i = 0; i < count; ++i) value |= bit() << i;
    return value;
}

std::uint32_t BasisBits::takeChunks(std::uint32_t bitsOfChunk) {
    std::uint32_t value = 0;
    for (std::uint32_t shift = 0; shift < 32; shift += bitsOfChunk) {
        value |= take(bitsOfChunk) << shift;
        if (bit() == 0) return value;
    }
    damagedBasis("a number is too long");
}

BasisHuffman::BasisHuffman(std::span<const std::uint8_t> lengths) {
    for (const std::uint8_t length : lengths) {
        if (length > 0) ++codesOf_[length];
    }
    std::uint32_t used = 0;  // of all codes of the greatest length
    for (std::uint32_t length = 1; length <= kMaxLength; ++length) {
        used += codesOf_[length] << (kMaxLength - length);
        for (std::size_t s = 0; s < lengths.size(); ++s) {
            if (lengths[s] == length) symbols_.push_back(static_cast<std::uint16_t>(s));
        }
    }
    if (used > 1u << kMaxLength) damagedBasis("a Huffman table has too many codes");
}

// The lengths are themselves coded, with runs of zeros and of repeated lengths.
BasisHuffman::BasisHuffman(BasisBits& bits) {
    enum : std::uint32_t { zeros = 17, manyZeros, repeats, manyRepeats, codeCount };
    constexpr std::array<std::uint8_t, codeCount> kOrder{17, 18, 19, 20, 0,  8, 7,  9, 6,  10, 5,
                                                         11, 4,  12, 3,  13, 2, 14, 1, 15, 16};
    const std::uint32_t count = bits.take(14);
    if (count == 0) return;
    const std::uint32_t stored = bits.take(5);
    if (stored == 0 || stored > codeCount) damagedBasis("a Huffman table has no codes");
    std::array<std::uint8_t, codeCount> lengthsOfLengths{};
    for (std::uint32_t i = 0; i < stored; ++i) {
        lengthsOfLengths[kOrder[i]] = static_cast<std::uint8_t>(bits.take(3));
    }
    const BasisHuffman code{std::span<const std::uint8_t>(lengthsOfLengths)};
    std::vector<std::uint8_t> lengths;
    lengths.reserve(count);
    while (lengths.size() < count) {
        const std::uint32_t symbol = code.symbol(bits);
        if (symbol < zeros) {
            lengths.push_back(static_cast<std::uint8_t>(symbol));
            continue;
        }
        const bool repeat = symbol >= repeats;
        const std::uint32_t run = symbol == zeros       ? bits.take(3) + 3
                                  : symbol == manyZeros ? bits.take(7) + 11
                                  : symbol == repeats   ? bits.take(2) + 3
                                                        : bits.take(7) + 7;
        if (run > count - lengths.size() || (repeat && lengths.empty())) {
            damagedBasis("a Huffman table has a run that is too long");
        }
        lengths.insert(lengths.end(), run, repeat ? lengths.back() : std::uint8_t{0});
    }
    *this = BasisHuffman(std::span<const std::uint8_t>(lengths));
}

std::uint32_t BasisHuffman::symbol(BasisBits& bits) const {
    std::uint32_t code = 0, first = 0, before = 0;  // before: number of shorter codes
    for (std::uint32_t length = 1; length <= kMaxLength; ++length) {
        code = code << 1 | bits.bit();
        first <<= 1;
        if (code - first < codesOf_[length]) return symbols_[before + code - first];
        first += codesOf_[length];
        before += codesOf_[length];
    }
    damagedBasis("it has an unknown Huffman code");
}

}  // namespace clerestory
