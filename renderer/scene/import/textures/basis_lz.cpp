#include "scene/import/textures/basis_lz.h"

#include "scene/import/textures/basis_bits.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

namespace clerestory {
namespace {

using BasisSpan = std::span<const unsigned char>;

struct Endpoint {
    std::array<std::uint8_t, 3> color{};  // 5 bits each
    std::uint8_t table = 0;               // of modifiers
};

using Selectors = std::array<std::uint8_t, 4>;  // a byte for each row, two bits for each texel

std::vector<Endpoint> endpointsIn(BasisSpan bytes, std::uint32_t count) {
    BasisBits bits(bytes);
    std::array<BasisHuffman, 3> colorDelta;  // for small, middle and large values before
    for (BasisHuffman& code : colorDelta) code = BasisHuffman(bits);
    const BasisHuffman tableDelta(bits);
    const bool grey = bits.bit() != 0;
    std::vector<Endpoint> endpoints(count);
    Endpoint last{{16, 16, 16}, 0};
    for (Endpoint& endpoint : endpoints) {
        last.table = (last.table + tableDelta.symbol(bits)) & 7;
        for (std::size_t c = 0; c < (grey ? 1 : 3); ++c) {
            const std::size_t model = last.color[c] <= 9 ? 0 : last.color[c] <= 21 ? 1 : 2;
            last.color[c] = (last.color[c] + colorDelta[model].symbol(bits)) & 31;
        }
        if (grey) last.color[1] = last.color[2] = last.color[0];
        endpoint = last;
    }
    return endpoints;
}

std::vector<Selectors> selectorsIn(BasisSpan bytes, std::uint32_t count) {
    BasisBits bits(bytes);
    if (bits.take(2) != 0) damagedBasis("it refers to a codebook outside the file");
    const bool raw = bits.bit() != 0;
    const BasisHuffman delta = raw ? BasisHuffman() : BasisHuffman(bits);
    std::vector<Selectors> selectors(count);
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t row = 0; row < 4; ++row) {
            const std::uint32_t byte =
                raw || i == 0 ? bits.take(8) : delta.symbol(bits) ^ selectors[i - 1][row];
            selectors[i][row] = static_cast<std::uint8_t>(byte);
        }
    }
    return selectors;
}

struct SliceCodes {
    explicit SliceCodes(BasisSpan bytes) {
        BasisBits bits(bytes);
        for (BasisHuffman* code : {&prediction, &endpointDelta, &selector, &runLength}) {
            *code = BasisHuffman(bits);
        }
        historySize = bits.take(13);
    }
    BasisHuffman prediction, endpointDelta, selector, runLength;
    std::uint32_t historySize = 0;
};

// Selectors of recent blocks; those that are used often move to the front.
class SelectorHistory {
public:
    explicit SelectorHistory(std::size_t size) : values_(size), next_(size / 2) {}
    std::size_t size() const { return values_.size(); }
    void add(std::uint32_t value) {
        if (values_.empty()) return;
        values_[next_] = value;
        if (++next_ == values_.size()) next_ = values_.size() / 2;
    }
    std::uint32_t use(std::size_t i) {
        const std::uint32_t value = values_[i];
        std::swap(values_[i / 2], values_[i]);
        return value;
    }

private:
    std::vector<std::uint32_t> values_;
    std::size_t next_;
};

// Decodes the blocks of a slice in order; each has the index of its endpoint and of its selectors.
class SliceDecoder {
public:
    SliceDecoder(BasisSpan bytes, const SliceCodes& codes, std::uint32_t endpointCount,
                 std::uint32_t selectorCount, std::uint32_t width)
        : bits_(bytes),
          codes_(codes),
          endpointCount_(endpointCount),
          selectorCount_(selectorCount),
          history_(codes.historySize),
          rows_{std::vector<std::uint32_t>(width), std::vector<std::uint32_t>(width)},
          predictionsBelow_(width) {}

    std::uint32_t endpoint(std::uint32_t x, std::uint32_t y) {
        if (x % 2 == 0) predictions_ = predictionsAt(x, y);
        const std::uint32_t prediction = predictions_ & 3;
        predictions_ >>= 2;
        const auto& above = rows_[(y + 1) % 2];
        const bool hasLeft = x > 0, hasAbove = y > 0;
        if ((prediction == 0 && !hasLeft) || (prediction == 1 && !hasAbove) ||
            (prediction == 2 && !(hasLeft && hasAbove))) {
            damagedBasis("a block refers to one outside the image");
        }
        if (prediction == 1) {
            last_ = above[x];
        } else if (prediction == 2) {
            last_ = above[x - 1];
        } else if (prediction == 3) {
            last_ += codes_.endpointDelta.symbol(bits_);
            if (last_ >= endpointCount_) last_ -= endpointCount_;
            if (last_ >= endpointCount_) damagedBasis("a block has an unknown endpoint");
        }
        return rows_[y % 2][x] = last_;
    }

    std::uint32_t selectors() {
        std::uint32_t symbol = selectorCount_;  // the first one of the history
        if (run_ > 0) {
            --run_;
        } else {
            symbol = codes_.selector.symbol(bits_);
            if (symbol == selectorCount_ + history_.size()) {
                constexpr std::uint32_t kLongest = 63, kShortest = 3;
                const std::uint32_t length = codes_.runLength.symbol(bits_);
                run_ = (length == kLongest ? bits_.takeChunks(7) : length) + kShortest - 1;
                symbol = selectorCount_;
            }
        }
        if (symbol < selectorCount_) {
            history_.add(symbol);
            return symbol;
        }
        if (symbol - selectorCount_ >= history_.size()) {
            damagedBasis("a block has unknown selectors");
        }
        return history_.use(symbol - selectorCount_);
    }

private:
    // Two bits for each of a row's two blocks. A symbol has those of 2 x 2 blocks.
    std::uint32_t predictionsAt(std::uint32_t x, std::uint32_t y) {
        if (y % 2 != 0) return predictionsBelow_[x];
        constexpr std::uint32_t kRepeat = 256, kShortest = 3;
        if (repeats_ > 0) {
            --repeats_;
        } else {
            const std::uint32_t symbol = codes_.prediction.symbol(bits_);
            if (symbol == kRepeat) {
                repeats_ = bits_.takeChunks(4) + kShortest - 1;
            } else {
                lastPredictions_ = symbol;
            }
        }
        predictionsBelow_[x] = lastPredictions_ >> 4;
        return lastPredictions_;
    }

    BasisBits bits_;
    const SliceCodes& codes_;
    std::uint32_t endpointCount_, selectorCount_;
    SelectorHistory history_;
    std::array<std::vector<std::uint32_t>, 2> rows_;  // endpoints of even and odd rows
    std::vector<std::uint32_t> predictionsBelow_;
    std::uint32_t predictions_ = 0, lastPredictions_ = 0, repeats_ = 0;
    std::uint32_t last_ = 0, run_ = 0;
};

// The modifiers of ETC1: Khronos Data Format Specification, "ETC1 Compressed Texture Image
// Formats".
constexpr int kBasisModifiers[8][4]{{-8, -2, 2, 8},       {-17, -5, 5, 17},    {-29, -9, 9, 29},
                                    {-42, -13, 13, 42},   {-60, -18, 18, 60},  {-80, -24, 24, 80},
                                    {-106, -33, 33, 106}, {-183, -47, 47, 183}};

// Into the colours of the image, or, from the green channel, into its alpha.
void writeBlock(const Endpoint& endpoint, const Selectors& selectors, std::uint32_t blockX,
                std::uint32_t blockY, bool alpha, TextureImage& image) {
    std::array<std::array<std::uint8_t, 3>, 4> colors{};
    for (std::size_t s = 0; s < 4; ++s) {
        for (std::size_t c = 0; c < 3; ++c) {
            const int base = endpoint.color[c] << 3 | endpoint.color[c] >> 2;
            colors[s][c] = static_cast<std::uint8_t>(
                std::clamp(base + kBasisModifiers[endpoint.table][s], 0, 255));
        }
    }
    for (std::uint32_t y = 4 * blockY; y < std::min(4 * blockY + 4, image.height); ++y) {
        for (std::uint32_t x = 4 * blockX; x < std::min(4 * blockX + 4, image.width); ++x) {
            const auto& color = colors[selectors[y % 4] >> 2 * (x % 4) & 3u];
            std::uint8_t* texel = &image.texels[4 * (std::size_t{y} * image.width + x)];
            if (alpha) {
                texel[3] = color[1];
            } else {
                std::copy(color.begin(), color.end(), texel);
                texel[3] = 255;
            }
        }
    }
}

}  // namespace

void decodeBasisLz(BasisSpan globalData, BasisSpan level, std::uint32_t imageCount,
                   TextureImage& image) {
    constexpr std::size_t kHeader = 20, kImageHeader = 20;
    const auto endpointCount = static_cast<std::uint32_t>(numberIn(globalData, 0, 2)),
               selectorCount = static_cast<std::uint32_t>(numberIn(globalData, 2, 2));
    std::size_t at = kHeader + std::size_t{imageCount} * kImageHeader;
    const auto nextPart = [&](std::size_t lengthField) {
        const std::size_t size = numberIn(globalData, lengthField, 4);
        const BasisSpan part = partOf(globalData, at, size);
        at += size;
        return part;
    };
    const std::vector<Endpoint> endpoints = endpointsIn(nextPart(4), endpointCount);
    const std::vector<Selectors> selectors = selectorsIn(nextPart(8), selectorCount);
    const SliceCodes codes(nextPart(12));
    if (endpoints.empty() || selectors.empty()) damagedBasis("its codebooks are empty");
    for (const bool alpha : {false, true}) {
        const std::size_t field = kHeader + (alpha ? 12 : 4);
        const BasisSpan slice =
            partOf(level, numberIn(globalData, field, 4), numberIn(globalData, field + 4, 4));
        if (alpha && slice.empty()) break;
        const std::uint32_t width = (image.width + 3) / 4, height = (image.height + 3) / 4;
        SliceDecoder decoder(slice, codes, endpointCount, selectorCount, width);
        for (std::uint32_t y = 0; y < height; ++y) {
            for (std::uint32_t x = 0; x < width; ++x) {
                const std::uint32_t e = decoder.endpoint(x, y), s = decoder.selectors();
                writeBlock(endpoints[e], selectors[s], x, y, alpha, image);
            }
        }
    }
}

}  // namespace clerestory
