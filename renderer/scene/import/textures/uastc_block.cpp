#include "scene/import/textures/uastc_block.h"

#include <algorithm>
#include <vector>

namespace clerestory {
namespace {

// Reads fields from the least significant bit upwards.
class UastcBits {
public:
    explicit UastcBits(std::span<const unsigned char, kUastcBlockBytes> block) {
        for (std::size_t i = 0; i < kUastcBlockBytes; ++i) {
            halves_[i / 8] |= std::uint64_t{block[i]} << 8 * (i % 8);
        }
    }
    // count: up to 32. Zeros after the last bit.
    std::uint32_t take(std::uint32_t count) {
        std::uint64_t value = at_ < 64 ? halves_[0] >> at_ : 0;
        if (at_ >= 64 && at_ < 128) value = halves_[1] >> (at_ - 64);
        if (at_ > 0 && at_ < 64) value |= halves_[1] << (64 - at_);
        at_ += count;
        return static_cast<std::uint32_t>(value & ((std::uint64_t{1} << count) - 1));
    }

private:
    std::array<std::uint64_t, 2> halves_{};
    std::uint32_t at_ = 0;
};

// How the values of endpoints are stored: 3^trits * 5^quints * 2^bits levels.
struct EndpointRange {
    std::uint8_t trits, quints, bits;
};
constexpr EndpointRange k12{1, 0, 2}, k16{0, 0, 4}, k32{0, 0, 5}, k40{0, 1, 3}, k48{1, 0, 4},
    k160{0, 1, 5}, k192{1, 0, 6}, k256{0, 0, 8};

// The two-subset patterns of modes 2, 4, 9 and 16 (pairs), those of mode 7 (splitTriples), and the
// three-subset patterns of mode 3.
enum class PatternList : std::uint8_t { none, pairs, splitTriples, triples };

struct UastcMode {
    std::uint8_t code, codeBits;  // the code's first bit is its least significant one
    std::uint8_t hintBits;        // for transcoding to other formats
    PatternList patterns;
    bool dualPlane;
    std::uint8_t components;  // 2: luminance and alpha
    EndpointRange endpoints;
    std::uint8_t weightBits;
};
constexpr std::size_t kSolidColor = 8;
constexpr std::array<UastcMode, 19> kModes{{
    {0x01, 4, 15, PatternList::none, false, 3, k192, 4},
    {0x35, 6, 15, PatternList::none, false, 3, k256, 2},
    {0x1D, 5, 15, PatternList::pairs, false, 3, k16, 3},
    {0x03, 5, 15, PatternList::triples, false, 3, k12, 2},
    {0x13, 5, 15, PatternList::pairs, false, 3, k40, 2},
    {0x0B, 5, 15, PatternList::none, false, 3, k256, 3},
    {0x1B, 5, 15, PatternList::none, true, 3, k160, 2},
    {0x07, 5, 15, PatternList::splitTriples, false, 3, k40, 2},
    {0x17, 5, 0, PatternList::none, false, 4, k256, 0},
    {0x0F, 5, 23, PatternList::pairs, false, 4, k16, 2},
    {0x02, 3, 17, PatternList::none, false, 4, k48, 4},
    {0x00, 2, 17, PatternList::none, true, 4, k48, 2},
    {0x06, 3, 17, PatternList::none, false, 4, k192, 3},
    {0x1F, 5, 23, PatternList::none, true, 4, k256, 1},
    {0x0D, 5, 23, PatternList::none, false, 4, k256, 2},
    {0x05, 7, 23, PatternList::none, false, 2, k256, 4},
    {0x15, 6, 23, PatternList::pairs, false, 2, k256, 2},
    {0x25, 6, 23, PatternList::none, true, 2, k256, 2},
    {0x09, 4, 15, PatternList::none, false, 3, k32, 5},
}};

// Partition seeds of ASTC whose patterns BC7 has, too.
constexpr std::array<std::uint16_t, 30> kPairSeeds{
    28, 20,  16,  29, 91,  9,   107, 72,  149, 204, 50,  114, 496, 17,  78,
    39, 252, 828, 43, 156, 116, 210, 476, 273, 684, 359, 246, 195, 694, 524};
constexpr std::array<std::uint16_t, 19> kSplitTripleSeeds{
    36, 48, 61, 137, 161, 183, 226, 281, 302, 307, 479, 495, 593, 594, 605, 799, 812, 988, 993};
constexpr std::array<std::uint16_t, 11> kTripleSeeds{260, 74, 32,  156, 183, 15,
                                                     745, 0,  335, 902, 254};

struct UastcPattern {
    std::uint32_t subsets = 1;
    std::array<std::uint8_t, 16> subsetOf{};
    std::array<std::uint8_t, 3> anchor{};  // the first texel of each subset
};

// The pseudo-random partition function of ASTC: Khronos Data Format Specification, "Partition
// pattern generation"; for blocks of 4 x 4, whose coordinates are doubled.
std::uint32_t hashOf(std::uint32_t p) {
    p ^= p >> 15;
    p -= p << 17;
    p += p << 7;
    p += p << 4;
    p ^= p >> 5;
    p += p << 16;
    p ^= p >> 7;
    p ^= p >> 3;
    p ^= p << 6;
    p ^= p >> 17;
    return p;
}

UastcPattern patternOf(std::uint32_t seed, std::uint32_t subsets) {
    const std::uint32_t number = hashOf(seed + (subsets - 1) * 1024);
    const std::uint32_t many = subsets == 3 ? 6 : 5, few = (seed & 2) != 0 ? 4 : 5;
    const std::uint32_t shifts[2] = {(seed & 1) != 0 ? few : many, (seed & 1) != 0 ? many : few};
    std::array<std::uint32_t, 6> factor{};  // of x and y, for each of three subsets
    for (std::uint32_t i = 0; i < 6; ++i) {
        const std::uint32_t digit = number >> 4 * i & 15;
        factor[i] = digit * digit >> shifts[i % 2];
    }
    UastcPattern pattern{.subsets = subsets};
    std::array<bool, 3> seen{};
    for (std::uint32_t texel = 0; texel < 16; ++texel) {
        const std::uint32_t x = texel % 4 * 2, y = texel / 4 * 2;
        const std::uint32_t a = (factor[0] * x + factor[1] * y + (number >> 14)) & 63;
        const std::uint32_t b = (factor[2] * x + factor[3] * y + (number >> 10)) & 63;
        const std::uint32_t c =
            subsets < 3 ? 0 : (factor[4] * x + factor[5] * y + (number >> 6)) & 63;
        const std::uint8_t subset = a >= b && a >= c ? 0 : b >= c ? 1 : 2;
        pattern.subsetOf[texel] = subset;
        if (!seen[subset]) pattern.anchor[subset] = static_cast<std::uint8_t>(texel);
        seen[subset] = true;
    }
    return pattern;
}

template <std::size_t N>
std::vector<UastcPattern> patternsOf(const std::array<std::uint16_t, N>& seeds,
                                     std::uint32_t subsets) {
    std::vector<UastcPattern> patterns;
    patterns.reserve(N);
    for (const std::uint32_t seed : seeds) patterns.push_back(patternOf(seed, subsets));
    return patterns;
}

const std::vector<UastcPattern>& patternsIn(PatternList list) {
    static const std::vector<UastcPattern> kNone{UastcPattern{}},
        kPairs = patternsOf(kPairSeeds, 2), kSplitTriples = patternsOf(kSplitTripleSeeds, 2),
        kTriples = patternsOf(kTripleSeeds, 3);
    return list == PatternList::pairs          ? kPairs
           : list == PatternList::splitTriples ? kSplitTriples
           : list == PatternList::triples      ? kTriples
                                               : kNone;
}

// Repeats the bits of a value up to the width.
constexpr std::uint32_t replicated(std::uint32_t value, std::uint32_t bits, std::uint32_t width) {
    std::uint32_t result = 0;
    for (std::uint32_t filled = 0; filled < width; filled += bits) {
        result = filled + bits <= width
                     ? result << bits | value
                     : result << (width - filled) | value >> (bits - (width - filled));
    }
    return result;
}

// Endpoint values 0..255: Khronos Data Format Specification, "Colour unquantization". `digit` is
// the trit or quint.
std::uint8_t endpointOf(const EndpointRange& range, std::uint32_t digit, std::uint32_t low) {
    if (range.trits + range.quints == 0) {
        return static_cast<std::uint8_t>(replicated(low, range.bits, 8));
    }
    const std::uint32_t a = (low & 1) != 0 ? 0x1FF : 0;
    const std::uint32_t high = low >> 1;  // the bits above the lowest one
    std::uint32_t b = 0, factor = 0;
    if (range.trits != 0) {
        switch (range.bits) {
            case 2:  // b000b0bb0
                b = high * 0x116, factor = 93;
                break;
            case 4:  // dcb000dcb
                b = high << 6 | high, factor = 22;
                break;
            default:  // fedcb000f
                b = high << 4 | high >> 4, factor = 5;
        }
    } else if (range.bits == 3) {  // cb0000cbc
        b = high << 7 | high << 1 | high >> 1, factor = 26;
    } else {  // edcb0000e
        b = high << 5 | high >> 3, factor = 6;
    }
    const std::uint32_t t = (digit * factor + b) ^ a;
    return static_cast<std::uint8_t>((a & 0x80) | t >> 2);
}

// All trits or quints come first, as numbers in base 3 or 5 of up to five or three digits, then
// the bits of all values.
std::array<std::uint8_t, 18> endpointsFrom(UastcBits& bits, const EndpointRange& range,
                                           std::uint32_t count) {
    std::array<std::uint32_t, 18> digits{};
    if (range.trits + range.quints > 0) {
        const std::uint32_t base = range.trits != 0 ? 3 : 5, group = range.trits != 0 ? 5 : 3;
        constexpr std::uint32_t kTritBits[] = {0, 2, 4, 5, 7, 8}, kQuintBits[] = {0, 3, 5, 7};
        for (std::uint32_t first = 0; first < count; first += group) {
            const std::uint32_t size = std::min(group, count - first);
            std::uint32_t number = bits.take(range.trits != 0 ? kTritBits[size] : kQuintBits[size]);
            for (std::uint32_t i = 0; i < size; ++i, number /= base) {
                digits[first + i] = number % base;
            }
        }
    }
    std::array<std::uint8_t, 18> endpoints{};
    for (std::uint32_t i = 0; i < count; ++i) {
        endpoints[i] = endpointOf(range, digits[i], bits.take(range.bits));
    }
    return endpoints;
}

// 0..64; the highest bit of a subset's first texel is 0 and not stored.
std::uint32_t weightFrom(UastcBits& bits, std::uint32_t width, bool anchor) {
    const std::uint32_t weight = replicated(bits.take(width - anchor), width, 6);
    return weight > 32 ? weight + 1 : weight;
}

std::uint8_t mixed(std::uint32_t low, std::uint32_t high, std::uint32_t weight) {
    return static_cast<std::uint8_t>((low * 257 * (64 - weight) + high * 257 * weight + 32) >> 14);
}

std::size_t modeFrom(UastcBits& bits, std::span<const unsigned char, kUastcBlockBytes> block) {
    for (std::size_t i = 0; i < kModes.size(); ++i) {
        const std::uint32_t mask = (1u << kModes[i].codeBits) - 1;
        if ((block[0] & mask) == kModes[i].code) {
            bits.take(kModes[i].codeBits);
            return i;
        }
    }
    return kModes.size();
}

}  // namespace

std::optional<UastcTexels> decodedUastc(std::span<const unsigned char, kUastcBlockBytes> block) {
    UastcBits bits(block);
    const std::size_t number = modeFrom(bits, block);
    if (number == kModes.size()) return std::nullopt;
    UastcTexels texels;
    if (number == kSolidColor) {
        for (std::uint8_t& c : texels[0]) c = static_cast<std::uint8_t>(bits.take(8));
        texels.fill(texels[0]);
        return texels;
    }
    const UastcMode& mode = kModes[number];
    bits.take(mode.hintBits);
    const auto& patterns = patternsIn(mode.patterns);
    const std::uint32_t index = mode.patterns == PatternList::none      ? 0
                                : mode.patterns == PatternList::triples ? bits.take(4)
                                                                        : bits.take(5);
    if (index >= patterns.size()) return std::nullopt;
    const UastcPattern& pattern = patterns[index];
    // The channel that the second plane has the weights of.
    const std::uint32_t separate = !mode.dualPlane ? 4 : mode.components == 2 ? 3 : bits.take(2);
    const std::uint32_t perSubset = 2u * mode.components;
    const auto endpoints = endpointsFrom(bits, mode.endpoints, perSubset * pattern.subsets);
    for (std::size_t texel = 0; texel < 16; ++texel) {
        const std::uint32_t subset = pattern.subsetOf[texel];
        const bool anchor = pattern.anchor[subset] == texel;
        const std::uint32_t weight = weightFrom(bits, mode.weightBits, anchor);
        const std::uint32_t second = mode.dualPlane ? weightFrom(bits, mode.weightBits, anchor) : 0;
        for (std::uint32_t c = 0; c < 4; ++c) {
            // Luminance and alpha, or red, green, blue and alpha.
            const std::uint32_t stored = mode.components > 2 ? c : c / 3;
            const std::size_t pair = subset * perSubset + 2 * stored;
            texels[texel][c] =
                stored >= mode.components
                    ? std::uint8_t{255}
                    : mixed(endpoints[pair], endpoints[pair + 1], c == separate ? second : weight);
        }
    }
    return texels;
}

}  // namespace clerestory
