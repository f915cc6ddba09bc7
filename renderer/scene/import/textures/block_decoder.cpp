// S3TC (EXT_texture_compression_s3tc) and ETC2 (OpenGL 4.3, appendix C).
#include "scene/import/textures/texel_format.h"

#include <algorithm>
#include <cstdint>

namespace clerestory {
namespace {

using Block = std::span<const unsigned char>;
using Color = glm::ivec3;  // 0..255

glm::vec3 light(const Color& c) {
    return glm::vec3(glm::clamp(c, 0, 255)) / 255.0f;
}

// Expands to eight bits by repeating the upper bits.
int from4(int x) {
    return x * 17;
}
int from5(int x) {
    return (x << 3) | (x >> 2);
}
int from6(int x) {
    return (x << 2) | (x >> 4);
}
int from7(int x) {
    return (x << 1) | (x >> 6);
}

Color from565(int c) {
    return {from5(c >> 11), from6((c >> 5) & 63), from5(c & 31)};
}

// ETC2 blocks are big-endian.
class Bits {
public:
    explicit Bits(Block block) {
        for (const unsigned char byte : block.first(8)) bits_ = bits_ << 8 | byte;
    }
    int operator()(int high, int low) const {
        return static_cast<int>((bits_ >> low) & ((1ull << (high - low + 1)) - 1));
    }

private:
    std::uint64_t bits_ = 0;
};

constexpr std::array<std::array<int, 2>, 8> kModifiers{
    {{2, 8}, {5, 17}, {9, 29}, {13, 42}, {18, 60}, {24, 80}, {33, 106}, {47, 183}}};
constexpr std::array kDistances{3, 6, 11, 16, 23, 32, 41, 64};

int signed3(int x) {
    return x < 4 ? x : x - 8;
}

// The two bits of a texel; texels are in column order.
int indexOf(const Bits& bits, int x, int y) {
    const int texel = 4 * x + y;
    return 2 * bits(16 + texel, 16 + texel) + bits(texel, texel);
}

BlockTexels planar(const Bits& b) {
    const Color origin(from6(b(62, 57)), from7(b(56, 56) << 6 | b(54, 49)),
                       from6(b(48, 48) << 5 | b(44, 43) << 3 | b(41, 39)));
    const Color right(from6(b(38, 34) << 1 | b(32, 32)), from7(b(31, 25)), from6(b(24, 19)));
    const Color below(from6(b(18, 13)), from7(b(12, 6)), from6(b(5, 0)));
    BlockTexels texels;
    for (int y = 0; y < 4; ++y) {
        for (int x = 0; x < 4; ++x) {
            const Color sum = x * (right - origin) + y * (below - origin) + 4 * origin + 2;
            texels[static_cast<std::size_t>(4 * y + x)] = light(sum >> 2);
        }
    }
    return texels;
}

BlockTexels painted(const Bits& b, const std::array<Color, 4>& paint, bool transparent) {
    BlockTexels texels;
    for (int y = 0; y < 4; ++y) {
        for (int x = 0; x < 4; ++x) {
            const int index = indexOf(b, x, y);
            const bool nothing = transparent && index == 2;
            texels[static_cast<std::size_t>(4 * y + x)] =
                nothing ? glm::vec3(0.0f) : light(paint[static_cast<std::size_t>(index)]);
        }
    }
    return texels;
}

BlockTexels modeT(const Bits& b, bool transparent) {
    const Color first(from4(b(60, 59) << 2 | b(57, 56)), from4(b(55, 52)), from4(b(51, 48)));
    const Color second(from4(b(47, 44)), from4(b(43, 40)), from4(b(39, 36)));
    const int d = kDistances[static_cast<std::size_t>(b(35, 34) << 1 | b(32, 32))];
    return painted(b, {first, second + d, second, second - d}, transparent);
}

BlockTexels modeH(const Bits& b, bool transparent) {
    const Color first(from4(b(62, 59)), from4(b(58, 56) << 1 | b(52, 52)),
                      from4(b(51, 51) << 3 | b(49, 47)));
    const Color second(from4(b(46, 43)), from4(b(42, 39)), from4(b(38, 35)));
    const auto order = [](const Color& c) { return c.x << 16 | c.y << 8 | c.z; };
    const int last = order(first) >= order(second) ? 1 : 0;
    const int d = kDistances[static_cast<std::size_t>(b(34, 34) << 2 | b(32, 32) << 1 | last)];
    return painted(b, {first + d, first - d, second + d, second - d}, transparent);
}

// Two halves, next to or above each other, each a base colour with four modifiers.
BlockTexels halves(const Bits& b, const std::array<Color, 2>& base, bool transparent) {
    const bool stacked = b(32, 32) == 1;
    const std::array<int, 2> table{b(39, 37), b(36, 34)};
    BlockTexels texels;
    for (int y = 0; y < 4; ++y) {
        for (int x = 0; x < 4; ++x) {
            const auto half = static_cast<std::size_t>(stacked ? y / 2 : x / 2);
            const auto& pair = kModifiers[static_cast<std::size_t>(table[half])];
            const int index = indexOf(b, x, y);
            int change = pair[static_cast<std::size_t>(index & 1)];
            if (transparent && index == 0) change = 0;
            if (index & 2) change = -change;
            const bool nothing = transparent && index == 2;
            texels[static_cast<std::size_t>(4 * y + x)] =
                nothing ? glm::vec3(0.0f) : light(base[half] + change);
        }
    }
    return texels;
}

}  // namespace

std::size_t blockBytes(BlockFormat format) {
    switch (format) {
        case BlockFormat::bc1:
        case BlockFormat::etc2:
        case BlockFormat::etc2Punchthrough:
            return 8;
        default:
            return 16;
    }
}

BlockTexels decodedS3tc(Block block, bool hasFourColoursOnly) {
    const int a = block[0] | block[1] << 8, b = block[2] | block[3] << 8;
    const Color first = from565(a), second = from565(b);
    std::array<Color, 4> paint{first, second, (2 * first + second) / 3, (first + 2 * second) / 3};
    if (a <= b && !hasFourColoursOnly) {
        paint[2] = (first + second) / 2;
        paint[3] = Color(0);
    }
    BlockTexels texels;
    for (std::size_t i = 0; i < 16; ++i) {
        texels[i] = light(paint[(block[4 + i / 4] >> (2 * (i % 4))) & 3]);
    }
    return texels;
}

BlockTexels decodedEtc2(Block block, bool punchthrough) {
    const Bits b(block);
    const bool flag = b(33, 33) == 1;
    const bool transparent = punchthrough && !flag;
    if (!flag && !punchthrough) {  // individual mode: each half has a base colour
        return halves(b,
                      {Color(from4(b(63, 60)), from4(b(55, 52)), from4(b(47, 44))),
                       Color(from4(b(59, 56)), from4(b(51, 48)), from4(b(43, 40)))},
                      false);
    }
    // Differential mode: an overflow selects another mode.
    const Color first(b(63, 59), b(55, 51), b(47, 43));
    const Color second = first + Color(signed3(b(58, 56)), signed3(b(50, 48)), signed3(b(42, 40)));
    const auto overflows = [](int x) { return x < 0 || x > 31; };
    if (overflows(second.x)) return modeT(b, transparent);
    if (overflows(second.y)) return modeH(b, transparent);
    if (overflows(second.z)) return planar(b);
    const auto whole = [](const Color& c) { return Color(from5(c.x), from5(c.y), from5(c.z)); };
    return halves(b, {whole(first), whole(second)}, transparent);
}

BlockTexels decodedBlock(BlockFormat format, Block block) {
    switch (format) {
        case BlockFormat::bc1:
            return decodedS3tc(block, false);
        case BlockFormat::bc3:
            return decodedS3tc(block.subspan(8), true);
        case BlockFormat::bc6hUnsigned:
            return decodedBc6h(block, false);
        case BlockFormat::bc6hSigned:
            return decodedBc6h(block, true);
        case BlockFormat::bc7:
            return decodedBc7(block);
        case BlockFormat::etc2:
            return decodedEtc2(block, false);
        case BlockFormat::etc2Punchthrough:
            return decodedEtc2(block, true);
        case BlockFormat::etc2Alpha:
            return decodedEtc2(block.subspan(8), false);
    }
    return {};
}

}  // namespace clerestory
