#include "display/contrast.h"

#include "image/bands.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace clerestory::display {
namespace {

// Codes of a very strong contrast, what it counts as nearby, and how far, in pixels.
constexpr std::uint8_t kStrong = 178, kNearStrong = 110;
constexpr std::int64_t kReach = 3;

// Rows of bytes, four for each pixel.
struct Rows {
    const std::uint8_t* bytes;
    std::int64_t width, height;
    const std::uint8_t* at(std::int64_t y) const {
        return bytes + 4 * width * std::clamp<std::int64_t>(y, 0, height - 1);
    }
};

// The least and the greatest code of three pixels one over the other, in each channel.
struct Column {
    std::array<std::uint8_t, 4> low, high;
};

// The contrast of each pixel of a row.
void contrastOfRow(const Rows& rows, std::int64_t y, std::uint8_t* contrast) {
    const std::uint8_t *above = rows.at(y - 1), *here = rows.at(y), *below = rows.at(y + 1);
    const auto columnAt = [&](std::int64_t x) {
        Column column;
        for (std::size_t c = 0; c < 4; ++c) {
            const std::size_t i = 4 * static_cast<std::size_t>(x) + c;
            column.low[c] = std::min({above[i], here[i], below[i]});
            column.high[c] = std::max({above[i], here[i], below[i]});
        }
        return column;
    };
    Column left = columnAt(0), middle = left;
    for (std::int64_t x = 0; x < rows.width; ++x) {
        const Column right = columnAt(std::min(x + 1, rows.width - 1));
        int most = 0;
        for (std::size_t c = 0; c < 4; ++c) {
            most = std::max(most, std::max({left.high[c], middle.high[c], right.high[c]}) -
                                      std::min({left.low[c], middle.low[c], right.low[c]}));
        }
        contrast[x] = static_cast<std::uint8_t>(most);
        left = middle;
        middle = right;
    }
}

// Raises what is near a very strong contrast.
void spread(std::vector<std::uint8_t>& contrast, std::int64_t width, std::int64_t height) {
    std::vector<std::uint8_t> near(contrast.size());
    for (std::int64_t y = 0; y < height; ++y) {
        for (std::int64_t x = 0; x < width; ++x) {
            if (contrast[y * width + x] < kStrong) continue;
            const std::int64_t first = std::max<std::int64_t>(0, x - kReach),
                               last = std::min(width - 1, x + kReach);
            for (std::int64_t row = std::max<std::int64_t>(0, y - kReach);
                 row <= std::min(height - 1, y + kReach); ++row) {
                std::fill_n(near.begin() + row * width + first, last - first + 1, kNearStrong);
            }
        }
    }
    for (std::size_t i = 0; i < contrast.size(); ++i) contrast[i] = std::max(contrast[i], near[i]);
}

// Pixels by their contrast.
std::array<std::size_t, 256> countsOf(const std::vector<std::uint8_t>& contrast) {
    std::array<std::size_t, 256> counts{};
    for (const std::uint8_t c : contrast) ++counts[c];
    return counts;
}

}  // namespace

std::vector<std::uint32_t> contrastingPixels(const Image& picture, const ContrastLimits& limits) {
    const Rows rows{picture.bytes(), picture.width, picture.height};
    std::vector<std::uint8_t> contrast(std::size_t{picture.width} * picture.height);
    forEachBand(picture.height, 16, [&](std::uint32_t first, std::uint32_t end) {
        for (std::uint32_t y = first; y < end; ++y) {
            contrastOfRow(rows, y, contrast.data() + std::size_t{y} * picture.width);
        }
    });
    spread(contrast, picture.width, picture.height);
    const auto most = static_cast<std::size_t>(limits.share * double(contrast.size()));
    const std::array<std::size_t, 256> counts = countsOf(contrast);
    std::size_t least = 256, above = 0;  // `above` pixels have at least `least`
    const auto wanted = static_cast<std::size_t>(std::ceil(limits.leastContrast * 255.0));
    while (least > wanted && above + counts[least - 1] <= most) above += counts[--least];
    // Of those of the next contrast as many as are allowed, evenly spread.
    const std::size_t room = least > wanted ? most - above : 0,
                      of = room > 0 ? counts[least - 1] : 1;
    std::vector<std::uint32_t> pixels;
    std::size_t seen = 0;
    for (std::size_t i = 0; i < contrast.size(); ++i) {
        bool isChosen = contrast[i] >= least;
        if (room > 0 && contrast[i] + std::size_t{1} == least) {
            isChosen = (seen + 1) * room / of > seen * room / of;
            ++seen;
        }
        if (isChosen) pixels.push_back(static_cast<std::uint32_t>(i));
    }
    return pixels;
}

}  // namespace clerestory::display
