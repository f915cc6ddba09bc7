// As edge_filter.frag, but only pixels on edges are computed.
#include "display/display.h"
#include "display/srgb_code.h"
#include "image/bands.h"
#include "shaders/include/bindings.glsl"

#include <glm/glm.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

namespace clerestory::display {
namespace {

// As in edge.glsl.
constexpr int kMinContrast = 8;  // codes
constexpr float kMinShare = 0.12f;
constexpr float kReach = 1.25f;
// Pixels that are tested at once.
constexpr int kGroup = 32;

using Color = glm::vec3;

// The brightness of a row and of its neighbours; beyond a border lies its nearest pixel.
struct Rows {
    const std::uint8_t *before, *row, *after;
};

// Calls visit(x) for those of kGroup pixels from `first` on that may lie on an edge. All have a
// left and a right neighbour.
template <class Visit>
void eachContrast(const Rows& rows, int first, const Visit& visit) {
    using Bytes = std::uint8_t __attribute__((vector_size(kGroup)));
    Bytes least, most, other;
    std::memcpy(&least, rows.row + first, kGroup);
    most = least;
    for (const std::uint8_t* from :
         {rows.row + first - 1, rows.row + first + 1, rows.before + first, rows.after + first}) {
        std::memcpy(&other, from, kGroup);
        least = other < least ? other : least;
        most = other > most ? other : most;
    }
    const auto found = most - least >= static_cast<std::uint8_t>(kMinContrast);
    std::array<std::uint64_t, kGroup / 8> words;
    std::memcpy(words.data(), &found, kGroup);
    for (std::uint64_t& word : words) {
        while (word != 0) {
            const int byte = std::countr_zero(word) / 8;
            visit(first + byte);
            word &= ~(std::uint64_t{0xff} << (8 * byte));
        }
        first += 8;
    }
}

class Smoothing {
public:
    Smoothing(const Picture& picture, bool ofSamples)
        : picture_(picture),
          most_(ofSamples ? EDGE_SHARE_OF_SAMPLES : 1.0f),
          width_(static_cast<int>(picture.image.width)),
          height_(static_cast<int>(picture.image.height)) {}

    // Writes those pixels of a row that lie on an edge.
    void smoothRow(int y, std::uint8_t* rgba) const {
        const Rows rows{brightness(std::max(y - 1, 0)), brightness(y),
                        brightness(std::min(y + 1, height_ - 1))};
        const auto smooth = [&](int x) { smoothPixel(rows, x, y, rgba + 4 * x); };
        int x = 0;
        smooth(x++);
        for (; x + kGroup < width_; x += kGroup) eachContrast(rows, x, smooth);
        for (; x < width_; ++x) smooth(x);
    }

private:
    const std::uint8_t* brightness(int y) const {
        return picture_.brightness.data() + static_cast<std::ptrdiff_t>(y) * width_;
    }

    void smoothPixel(const Rows& rows, int x, int y, std::uint8_t* rgba) const {
        const int left = std::max(x - 1, 0), right = std::min(x + 1, width_ - 1);
        const int center = rows.row[x], before = rows.before[x], after = rows.after[x];
        const int least =
            std::min({center, int{rows.row[left]}, int{rows.row[right]}, before, after});
        const int most =
            std::max({center, int{rows.row[left]}, int{rows.row[right]}, before, after});
        if (most - least < kMinContrast ||
            static_cast<float>(most - least) <= kMinShare * static_cast<float>(most)) {
            return;
        }
        // Two corners show the gradient of an edge that passes next to the pixel.
        constexpr float kCode = 1.0f / 255.0f;
        const float corners = 0.5f * static_cast<float>(rows.after[right] - rows.before[left]);
        const float gx = kCode * (static_cast<float>(rows.row[right] - rows.row[left]) + corners);
        const float gy = kCode * (static_cast<float>(after - before) + corners);
        const float larger = std::max({std::abs(gx), std::abs(gy), 1e-3f});
        const float scale = 0.25f / std::max(std::min(std::abs(gx), std::abs(gy)), 0.125f * larger);
        const float dx = std::clamp(-gy * scale, -0.25f * kReach, 0.25f * kReach);
        const float dy = std::clamp(gx * scale, -0.25f * kReach, 0.25f * kReach);
        Color light(0.0f);
        addLookup(static_cast<float>(x) - dx, static_cast<float>(y) - dy, light);
        addLookup(static_cast<float>(x) + dx, static_cast<float>(y) + dy, light);
        const float share = most_ * unsmoothed({rows.row[left], before}, center,
                                               {rows.row[right], after}, most - least);
        // As edge_filter.frag's blended().
        for (int i = 0; i < 3; ++i) {
            const float twice = std::max(2.0f * light[i] - lightOf(rgba[i]), 0.0f);
            const std::uint8_t code =
                codes_.code(picture_.compressed ? compressed(twice) : std::min(twice, 1.0f));
            const float change = 0.5f * share * static_cast<float>(code - rgba[i]);
            rgba[i] = static_cast<std::uint8_t>(static_cast<float>(rgba[i]) + change + 0.5f);
        }
    }

    // As in edge.glsl, for codes.
    static float unsmoothed(const glm::ivec2& low, int center, const glm::ivec2& high,
                            int contrast) {
        const glm::ivec2 before = center - low, after = high - center;
        const float most = static_cast<float>(std::max(contrast, 4 * kMinContrast));
        float sum = 0.0f, weights = 1e-12f;
        for (int axis = 0; axis < 2; ++axis) {
            const int a = std::abs(before[axis]), b = std::abs(after[axis]);
            const bool between = before[axis] * after[axis] > 0;
            const float part = between ? static_cast<float>(std::min(a, b)) / most : 0.0f;
            const float weight = static_cast<float>((a + b) * (a + b));
            sum += weight * part * part;
            weights += weight;
        }
        return 1.0f - 4.0f * sum / weights;
    }

    float lightOf(std::uint8_t code) const {
        return picture_.compressed ? codes_.uncompressed(code) : codes_.light(code);
    }

    // Half of a bilinear look-up, in linear light; pixel centres are at integers.
    void addLookup(float x, float y, Color& light) const {
        const float left = std::floor(x), top = std::floor(y);
        const float right = x - left, lower = y - top;
        const int x0 = static_cast<int>(left), y0 = static_cast<int>(top);
        add(x0, y0, 0.5f * (1.0f - right) * (1.0f - lower), light);
        add(x0 + 1, y0, 0.5f * right * (1.0f - lower), light);
        add(x0, y0 + 1, 0.5f * (1.0f - right) * lower, light);
        add(x0 + 1, y0 + 1, 0.5f * right * lower, light);
    }

    void add(int x, int y, float share, Color& light) const {
        x = std::clamp(x, 0, width_ - 1);
        y = std::clamp(y, 0, height_ - 1);
        const std::uint8_t* rgba =
            picture_.image.bytes() + 4 * (static_cast<std::ptrdiff_t>(y) * width_ + x);
        for (int i = 0; i < 3; ++i) {
            light[i] += share * lightOf(rgba[i]);
        }
    }

    const Picture& picture_;
    const float most_;  // share of the result
    int width_, height_;
    const SrgbCodes& codes_ = srgbCodes();
};

}  // namespace

void smoothEdges(const Picture& picture, bool ofSamples, Image& image) {
    reshape(image, picture.image.width, picture.image.height, 4, PixelType::srgb8);
    const Smoothing smoothing(picture, ofSamples);
    const std::size_t stride = std::size_t{4} * image.width;
    forEachBand(image.height, 16, [&](std::uint32_t first, std::uint32_t end) {
        for (std::uint32_t y = first; y < end; ++y) {
            std::memcpy(image.bytes() + stride * y, picture.image.bytes() + stride * y, stride);
            smoothing.smoothRow(static_cast<int>(y), image.bytes() + stride * y);
        }
    });
}

}  // namespace clerestory::display
