// BC6H and BC7 (ARB_texture_compression_bptc): up to three gradients in one block (subsets), and a
// partition of the texels among them.
#include "scene/import/textures/texel_format.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace clerestory {
namespace {

using Block = std::span<const unsigned char>;

// Reads bits, starting with the lowest bit of the first byte.
class BitReader {
public:
    explicit BitReader(Block block) : block_(block) {}
    int operator()(int count) {
        int value = 0;
        for (int i = 0; i < count && at_ < 128; ++i, ++at_) {
            value |= ((block_[static_cast<std::size_t>(at_ / 8)] >> (at_ % 8)) & 1) << i;
        }
        return value;
    }

private:
    Block block_;
    int at_ = 0;
};

// Partitions into two subsets: one bit for each texel, the first texel lowest.
constexpr std::array<std::uint16_t, 64> kPairs{
    0xCCCC, 0x8888, 0xEEEE, 0xECC8, 0xC880, 0xFEEC, 0xFEC8, 0xEC80, 0xC800, 0xFFEC, 0xFE80,
    0xE800, 0xFFE8, 0xFF00, 0xFFF0, 0xF000, 0xF710, 0x008E, 0x7100, 0x08CE, 0x008C, 0x7310,
    0x3100, 0x8CCE, 0x088C, 0x3110, 0x6666, 0x366C, 0x17E8, 0x0FF0, 0x718E, 0x399C, 0xAAAA,
    0xF0F0, 0x5A5A, 0x33CC, 0x3C3C, 0x55AA, 0x9696, 0xA55A, 0x73CE, 0x13C8, 0x324C, 0x3BDC,
    0x6996, 0xC33C, 0x9966, 0x0660, 0x0272, 0x04E4, 0x4E40, 0x2720, 0xC936, 0x936C, 0x39C6,
    0x639C, 0x9336, 0x9CC6, 0x817E, 0xE718, 0xCCF0, 0x0FCC, 0x7744, 0xEE22};

// Partitions into three subsets: two bits for each texel.
constexpr std::array<std::uint32_t, 64> kTriples{
    0xAA685050, 0x6A5A5040, 0x5A5A4200, 0x5450A0A8, 0xA5A50000, 0xA0A05050, 0x5555A0A0, 0x5A5A5050,
    0xAA550000, 0xAA555500, 0xAAAA5500, 0x90909090, 0x94949494, 0xA4A4A4A4, 0xA9A59450, 0x2A0A4250,
    0xA5945040, 0x0A425054, 0xA5A5A500, 0x55A0A0A0, 0xA8A85454, 0x6A6A4040, 0xA4A45000, 0x1A1A0500,
    0x0050A4A4, 0xAAA59090, 0x14696914, 0x69691400, 0xA08585A0, 0xAA821414, 0x50A4A450, 0x6A5A0200,
    0xA9A58000, 0x5090A0A8, 0xA8A09050, 0x24242424, 0x00AA5500, 0x24924924, 0x24499224, 0x50A50A50,
    0x500AA550, 0xAAAA4444, 0x66660000, 0xA5A0A5A0, 0x50A050A0, 0x69286928, 0x44AAAA44, 0x66666600,
    0xAA444444, 0x54A854A8, 0x95809580, 0x96969600, 0xA85454A8, 0x80959580, 0xAA141414, 0x96960000,
    0xAAAA1414, 0xA05050A0, 0xA0A5A5A0, 0x96000000, 0x40804080, 0xA9A8A9A8, 0xAAAAAA44, 0x2A4A5254};

// Anchor texels of the second and third subset, whose index has one bit less.
constexpr std::array<std::uint8_t, 64> kAnchorOfPair{
    15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 2,  8, 2, 2, 8,
    8,  15, 2,  8,  2,  2,  8,  8,  2,  2,  15, 15, 6,  8,  2,  8,  15, 15, 2, 8, 2, 2,
    2,  15, 15, 6,  6,  2,  6,  8,  15, 15, 2,  2,  15, 15, 15, 15, 15, 2,  2, 15};
constexpr std::array<std::uint8_t, 64> kSecondAnchor{
    3,  3,  15, 15, 8, 3,  15, 15, 8,  8,  6, 6,  6, 5,  3, 3,  3,  3,  8,  15, 3,  3,
    6,  10, 5,  8,  8, 6,  8,  5,  15, 15, 8, 15, 3, 5,  6, 10, 8,  15, 15, 3,  15, 5,
    15, 15, 15, 15, 3, 15, 5,  5,  5,  8,  5, 10, 5, 10, 8, 13, 15, 12, 3,  3};
constexpr std::array<std::uint8_t, 64> kThirdAnchor{
    15, 8, 8, 3,  15, 15, 3,  8,  15, 15, 15, 15, 15, 15, 15, 8,  15, 8,  15, 3,  15, 8,
    15, 8, 3, 15, 6,  10, 15, 15, 10, 8,  15, 3,  15, 10, 10, 8,  9,  10, 6,  15, 8,  15,
    3,  6, 6, 8,  15, 3,  15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 3,  15, 15, 8};

constexpr std::array kWeights2{0, 21, 43, 64};
constexpr std::array kWeights3{0, 9, 18, 27, 37, 46, 55, 64};
constexpr std::array kWeights4{0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64};

int weightOf(int bits, int index) {
    const auto i = static_cast<std::size_t>(index);
    return bits == 2 ? kWeights2[i] : bits == 3 ? kWeights3[i] : kWeights4[i];
}

int between(int a, int b, int weight) {
    return ((64 - weight) * a + weight * b + 32) >> 6;
}

// The subset of each texel, and whether it is an anchor: its index lacks the highest bit, which is
// 0.
struct Pattern {
    int gradients = 1;
    int number = 0;

    int gradientOf(std::size_t texel) const {
        const auto n = static_cast<std::size_t>(number);
        if (gradients == 2) return (kPairs[n] >> texel) & 1;
        if (gradients == 3) return static_cast<int>((kTriples[n] >> (2 * texel)) & 3);
        return 0;
    }
    bool isAnchor(std::size_t texel) const {
        const auto n = static_cast<std::size_t>(number);
        return texel == 0 || (gradients == 2 && texel == kAnchorOfPair[n]) ||
               (gradients == 3 && (texel == kSecondAnchor[n] || texel == kThirdAnchor[n]));
    }
};

// ---- BC7 -----------------------------------------------------------------------------------

struct Bc7Mode {
    int gradients, patternBits, rotationBits, selectorBits, colorBits, alphaBits;
    bool ownLastBits, sharedLastBits;  // of each endpoint; of both endpoints of a subset
    int indexBits, secondIndexBits;
};
constexpr std::array<Bc7Mode, 8> kBc7Modes{{{3, 4, 0, 0, 4, 0, true, false, 3, 0},
                                            {2, 6, 0, 0, 6, 0, false, true, 3, 0},
                                            {3, 6, 0, 0, 5, 0, false, false, 2, 0},
                                            {2, 6, 0, 0, 7, 0, true, false, 2, 0},
                                            {1, 0, 2, 1, 5, 6, false, false, 2, 3},
                                            {1, 0, 2, 0, 7, 8, false, false, 2, 2},
                                            {1, 0, 0, 0, 7, 7, true, false, 4, 0},
                                            {2, 6, 0, 0, 5, 5, true, false, 2, 0}}};

std::array<int, 16> indicesOf(BitReader& read, const Pattern& pattern, int bits) {
    std::array<int, 16> indices{};
    for (std::size_t i = 0; i < 16; ++i) indices[i] = read(bits - (pattern.isAnchor(i) ? 1 : 0));
    return indices;
}

}  // namespace

BlockTexels decodedBc7(Block block) {
    const int number = std::countr_zero(block[0]);
    if (number > 7) return {};  // reserved: black
    const Bc7Mode& mode = kBc7Modes[static_cast<std::size_t>(number)];
    BitReader read(block);
    read(number + 1);
    const Pattern pattern{mode.gradients, read(mode.patternBits)};
    const int rotation = read(mode.rotationBits), selector = read(mode.selectorBits);
    std::array<glm::ivec4, 6> ends{};  // two for each subset
    const auto count = static_cast<std::size_t>(2 * mode.gradients);
    for (int c = 0; c < 4; ++c) {
        for (std::size_t e = 0; e < count; ++e) {
            ends[e][c] = read(c < 3 ? mode.colorBits : mode.alphaBits);
        }
    }
    const int lastBits = mode.ownLastBits || mode.sharedLastBits ? 1 : 0;
    for (std::size_t e = 0; e < count && lastBits; e += 2) {
        const int first = read(1), second = mode.ownLastBits ? read(1) : first;
        ends[e] = 2 * ends[e] + first;
        ends[e + 1] = 2 * ends[e + 1] + second;
    }
    for (std::size_t e = 0; e < count; ++e) {
        for (int c = 0; c < 4; ++c) {
            const int bits = c < 3 ? mode.colorBits : mode.alphaBits;
            if (bits == 0) {
                ends[e][c] = 255;
                continue;
            }
            const int whole = ends[e][c] << (8 - bits - lastBits);
            ends[e][c] = whole | (whole >> (bits + lastBits));
        }
    }
    const std::array<int, 16> first = indicesOf(read, pattern, mode.indexBits);
    std::array<int, 16> second = first;
    int colorBits = mode.indexBits, alphaBits = mode.indexBits;
    if (mode.secondIndexBits > 0) {
        second = indicesOf(read, pattern, mode.secondIndexBits);
        alphaBits = mode.secondIndexBits;
    }
    if (selector == 1) std::swap(colorBits, alphaBits);
    BlockTexels texels;
    for (std::size_t i = 0; i < 16; ++i) {
        const auto e = static_cast<std::size_t>(2 * pattern.gradientOf(i));
        const int colorWeight = weightOf(colorBits, selector == 1 ? second[i] : first[i]);
        const int alphaWeight = weightOf(alphaBits, selector == 1 ? first[i] : second[i]);
        glm::ivec4 color;
        for (int c = 0; c < 4; ++c) {
            color[c] = between(ends[e][c], ends[e + 1][c], c < 3 ? colorWeight : alphaWeight);
        }
        if (rotation > 0) std::swap(color[3], color[rotation - 1]);
        texels[i] = glm::vec3(color) / 255.0f;
    }
    return texels;
}

// ---- BC6H ----------------------------------------------------------------------------------

namespace {

// The layout of the endpoints: the first one complete, the others as differences to it in some
// modes. A field is channel and endpoint, then its bits from the last one read to the first one:
// "rw9-0" reads bits 0 to 9 of red of endpoint w; "gy4" reads one bit; "rw10-15" reads bit 15
// first.
struct Bc6hMode {
    int number, bits;  // of the mode field, which is first
    bool differs;
    int endBits;
    std::array<int, 3> differenceBits;
    int gradients;
    const char* fields;
};
constexpr std::array<Bc6hMode, 14> kBc6hModes{{
    {0x00,
     2,
     true,
     10,
     {5, 5, 5},
     2,
     "gy4 by4 bz4 rw9-0 gw9-0 bw9-0 rx4-0 gz4 gy3-0 gx4-0 bz0 gz3-0 bx4-0 bz1 by3-0 ry4-0 bz2 "
     "rz4-0 bz3"},
    {0x01,
     2,
     true,
     7,
     {6, 6, 6},
     2,
     "gy5 gz4 gz5 rw6-0 bz0 bz1 by4 gw6-0 by5 bz2 gy4 bw6-0 bz3 bz5 bz4 rx5-0 gy3-0 gx5-0 gz3-0 "
     "bx5-0 by3-0 ry5-0 rz5-0"},
    {0x02,
     5,
     true,
     11,
     {5, 4, 4},
     2,
     "rw9-0 gw9-0 bw9-0 rx4-0 rw10 gy3-0 gx3-0 gw10 bz0 gz3-0 bx3-0 bw10 bz1 by3-0 ry4-0 bz2 "
     "rz4-0 bz3"},
    {0x06,
     5,
     true,
     11,
     {4, 5, 4},
     2,
     "rw9-0 gw9-0 bw9-0 rx3-0 rw10 gz4 gy3-0 gx4-0 gw10 gz3-0 bx3-0 bw10 bz1 by3-0 ry3-0 bz0 bz2 "
     "rz3-0 gy4 bz3"},
    {0x0a,
     5,
     true,
     11,
     {4, 4, 5},
     2,
     "rw9-0 gw9-0 bw9-0 rx3-0 rw10 by4 gy3-0 gx3-0 gw10 bz0 gz3-0 bx4-0 bw10 by3-0 ry3-0 bz1 bz2 "
     "rz3-0 bz4 bz3"},
    {0x0e,
     5,
     true,
     9,
     {5, 5, 5},
     2,
     "rw8-0 by4 gw8-0 gy4 bw8-0 bz4 rx4-0 gz4 gy3-0 gx4-0 bz0 gz3-0 bx4-0 bz1 by3-0 ry4-0 bz2 "
     "rz4-0 bz3"},
    {0x12,
     5,
     true,
     8,
     {6, 5, 5},
     2,
     "rw7-0 gz4 by4 gw7-0 bz2 gy4 bw7-0 bz3 bz4 rx5-0 gy3-0 gx4-0 bz0 gz3-0 bx4-0 bz1 by3-0 "
     "ry5-0 rz5-0"},
    {0x16,
     5,
     true,
     8,
     {5, 6, 5},
     2,
     "rw7-0 bz0 by4 gw7-0 gy5 gy4 bw7-0 gz5 bz4 rx4-0 gz4 gy3-0 gx5-0 gz3-0 bx4-0 bz1 by3-0 "
     "ry4-0 bz2 rz4-0 bz3"},
    {0x1a,
     5,
     true,
     8,
     {5, 5, 6},
     2,
     "rw7-0 bz1 by4 gw7-0 by5 gy4 bw7-0 bz5 bz4 rx4-0 gz4 gy3-0 gx4-0 bz0 gz3-0 bx5-0 by3-0 "
     "ry4-0 bz2 rz4-0 bz3"},
    {0x1e,
     5,
     false,
     6,
     {6, 6, 6},
     2,
     "rw5-0 gz4 bz0 bz1 by4 gw5-0 gy5 by5 bz2 gy4 bw5-0 gz5 bz3 bz5 bz4 rx5-0 gy3-0 gx5-0 gz3-0 "
     "bx5-0 by3-0 ry5-0 rz5-0"},
    {0x03, 5, false, 10, {10, 10, 10}, 1, "rw9-0 gw9-0 bw9-0 rx9-0 gx9-0 bx9-0"},
    {0x07, 5, true, 11, {9, 9, 9}, 1, "rw9-0 gw9-0 bw9-0 rx8-0 rw10 gx8-0 gw10 bx8-0 bw10"},
    {0x0b,
     5,
     true,
     12,
     {8, 8, 8},
     1,
     "rw9-0 gw9-0 bw9-0 rx7-0 rw10-11 gx7-0 gw10-11 bx7-0 bw10-11"},
    {0x0f,
     5,
     true,
     16,
     {4, 4, 4},
     1,
     "rw9-0 gw9-0 bw9-0 rx3-0 rw10-15 gx3-0 gw10-15 bx3-0 bw10-15"},
}};

int signExtended(int value, int bits) {
    const int sign = 1 << (bits - 1);
    return (value ^ sign) - sign;
}

// Expands to sixteen bits.
int unquantised(int x, int bits, bool isSigned) {
    if (!isSigned) {
        if (bits >= 15 || x == 0) return x;
        if (x == (1 << bits) - 1) return 0xFFFF;
        return ((x << 15) + 0x4000) >> (bits - 1);
    }
    if (bits >= 16) return x;
    const int size = std::abs(x);
    int wide = 0;
    if (size == 0)
        wide = 0;
    else if (size >= (1 << (bits - 1)) - 1)
        wide = 0x7FFF;
    else
        wide = ((size << 15) + 0x4000) >> (bits - 1);
    return x < 0 ? -wide : wide;
}

float valueOfHalf(int bits) {
    const int exponent = (bits >> 10) & 31, fraction = bits & 1023;
    const float size = exponent == 0
                           ? std::ldexp(static_cast<float>(fraction), -24)
                           : std::ldexp(static_cast<float>(1024 + fraction), exponent - 25);
    return bits & 0x8000 ? -size : size;
}

// Final scaling: the result is finite.
float finished(int x, bool isSigned) {
    if (!isSigned) return valueOfHalf((x * 31) >> 6);
    return x < 0 ? valueOfHalf(0x8000 | ((-x * 31) >> 5)) : valueOfHalf((x * 31) >> 5);
}

}  // namespace

BlockTexels decodedBc6h(Block block, bool isSigned) {
    const int two = block[0] & 3, five = block[0] & 31;
    const auto mode = std::find_if(kBc6hModes.begin(), kBc6hModes.end(), [&](const Bc6hMode& m) {
        return m.number == (m.bits == 2 ? two : five);
    });
    if (mode == kBc6hModes.end()) return {};  // reserved: black
    BitReader read(block);
    read(mode->bits);
    std::array<glm::ivec3, 4> ends{};
    for (const char* f = mode->fields; *f != '\0'; ++f) {
        if (*f == ' ') continue;
        const int channel = *f == 'r' ? 0 : *f == 'g' ? 1 : 2;
        int& end = ends[static_cast<std::size_t>(*++f - 'w')][channel];
        const auto number = [&] {
            int n = 0;
            while (f[1] >= '0' && f[1] <= '9') n = 10 * n + (*++f - '0');
            return n;
        };
        const int high = number();
        int low = high;
        if (f[1] == '-') {
            ++f;
            low = number();
        }
        const int step = low <= high ? 1 : -1;
        for (int bit = low;; bit += step) {
            end |= read(1) << bit;
            if (bit == high) break;
        }
    }
    Pattern pattern{mode->gradients, 0};
    if (mode->gradients == 2) pattern.number = read(5);
    const std::size_t count = mode->gradients == 2 ? 4 : 2;
    for (int c = 0; c < 3; ++c) {
        if (isSigned) ends[0][c] = signExtended(ends[0][c], mode->endBits);
        for (std::size_t e = 1; e < count; ++e) {
            int& end = ends[e][c];
            if (mode->differs) {
                end = signExtended(end, mode->differenceBits[static_cast<std::size_t>(c)]);
                end = (ends[0][c] + end) & ((1 << mode->endBits) - 1);
            }
            if (isSigned) end = signExtended(end, mode->endBits);
        }
    }
    for (std::size_t e = 0; e < count; ++e) {
        for (int c = 0; c < 3; ++c) ends[e][c] = unquantised(ends[e][c], mode->endBits, isSigned);
    }
    const int indexBits = mode->gradients == 2 ? 3 : 4;
    const std::array<int, 16> indices = indicesOf(read, pattern, indexBits);
    BlockTexels texels;
    for (std::size_t i = 0; i < 16; ++i) {
        const auto e = static_cast<std::size_t>(2 * pattern.gradientOf(i));
        for (int c = 0; c < 3; ++c) {
            texels[i][c] = finished(
                between(ends[e][c], ends[e + 1][c], weightOf(indexBits, indices[i])), isSigned);
        }
    }
    return texels;
}

}  // namespace clerestory
