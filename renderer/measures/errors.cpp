#include "measures/errors.h"

#include "measures/measured_pixels.h"

#include <glm/glm.hpp>
#include <glm/gtc/integer.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace clerestory {
namespace {

// Used for a black reference; far below the resolution of half-float frames.
constexpr double kMinFloor = 1e-9;
// Lower noise is rounding.
constexpr double kMinNoise = 1e-12;

template <class Visit>
void eachCounted(const ComparedPair& pair, Visit&& visit) {
    for (std::size_t i = 0; i < pair.counted.size(); ++i) {
        if (!pair.counted[i]) continue;
        for (std::size_t c = 0; c < 3; ++c) {
            visit(pair.actual[c].values[i], pair.reference[c].values[i]);
        }
    }
}

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
namespace glsl {
using namespace glm;
using uint = unsigned int;
#include "shaders/include/optics.glsl"
// After optics.glsl, which they need.
#include "shaders/include/srgb.glsl"
#include "shaders/include/tonemap.glsl"
}  // namespace glsl
#pragma GCC diagnostic pop

glm::vec3 toneMapped(glm::vec3 radiance, ToneMap curve) {
    switch (curve) {
        case ToneMap::neutral:
            return glsl::toneMapNeutral(radiance);
        case ToneMap::aces:
            return glsl::toneMapAces(radiance);
        case ToneMap::linear:
            break;
    }
    return glsl::toneMapLinear(radiance);
}

glm::dvec3 clampedPixel(const Layers& layers, std::size_t i) {
    return glm::clamp(glm::dvec3(layers[0].values[i], layers[1].values[i], layers[2].values[i]),
                      0.0, 1.0);
}

Layer luma(const Layers& rgb) {
    Layer result = rgb[0];
    for (std::size_t i = 0; i < result.values.size(); ++i) {
        result.values[i] = glm::dot(glm::dvec3(0.299, 0.587, 0.114), clampedPixel(rgb, i));
    }
    return result;
}

Layer product(const Layer& a, const Layer& b) {
    Layer result = a;
    for (std::size_t i = 0; i < result.values.size(); ++i) result.values[i] *= b.values[i];
    return result;
}

Layer blurred(const Layer& layer) {
    const std::vector<double> window = gaussian(1.5, 5);
    return filtered(layer, window, window);
}

// Wang et al. (2004), equation 13, at every pixel.
Layer similarity(const Layer& x, const Layer& y) {
    constexpr double kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;  // of a range of 1
    const Layer meanX = blurred(x), meanY = blurred(y);
    const Layer xx = blurred(product(x, x)), yy = blurred(product(y, y));
    const Layer xy = blurred(product(x, y));
    Layer result = x;
    for (std::size_t i = 0; i < result.values.size(); ++i) {
        const double mx = meanX.values[i], my = meanY.values[i];
        const double varX = std::max(xx.values[i] - mx * mx, 0.0);
        const double varY = std::max(yy.values[i] - my * my, 0.0);
        const double covariance = xy.values[i] - mx * my;
        result.values[i] = (2.0 * mx * my + kC1) * (2.0 * covariance + kC2) /
                           ((mx * mx + my * my + kC1) * (varX + varY + kC2));
    }
    return result;
}

// Excludes pixels whose window exceeds the image, unless that excludes all.
void excludeBorder(ComparedPair& pair) {
    const auto [width, height] = std::pair(pair.actual[0].width, pair.actual[0].height);
    if (width < 11 || height < 11) return;
    ComparedPair inner = pair;
    inner.pixels = 0;
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
            const bool within = x >= 5 && y >= 5 && x + 5 < width && y + 5 < height;
            auto& counted = inner.counted[std::size_t(y) * width + x];
            counted = counted && within;
            inner.pixels += counted;
        }
    }
    if (inner.pixels > 0) pair = std::move(inner);
}

}  // namespace

LinearErrors linearErrors(const Image& actual, const Image& reference, const Mask* mask) {
    const ComparedPair pair = comparedPair(actual, reference, mask, PixelType::float32);
    LinearErrors errors{.pixels = pair.pixels, .nonFinite = pair.nonFinite};
    if (pair.pixels == 0) return errors;

    const double samples = 3.0 * double(pair.pixels);
    std::vector<double> differences;
    differences.reserve(3 * pair.pixels);
    double radiance = 0.0, difference = 0.0, squares = 0.0;
    eachCounted(pair, [&](double x, double r) {
        radiance += r;
        difference += x - r;
        squares += (x - r) * (x - r);
        differences.push_back(std::abs(x - r));
    });
    errors.meanReference = radiance / samples;
    errors.bias = difference / samples;
    errors.rmse = std::sqrt(squares / samples);

    const double floor = std::max(kRelativeFloor * std::abs(errors.meanReference), kMinFloor);
    std::vector<double> relative;  // of each pixel
    relative.reserve(pair.pixels);
    for (std::size_t i = 0; i < pair.counted.size(); ++i) {
        if (!pair.counted[i]) continue;
        double sum = 0.0;
        for (std::size_t c = 0; c < 3; ++c) {
            const double x = pair.actual[c].values[i], r = pair.reference[c].values[i];
            sum += (x - r) * (x - r) / (r * r + floor * floor);
        }
        relative.push_back(sum);
    }
    errors.relMse = std::accumulate(relative.begin(), relative.end(), 0.0) / samples;
    const auto kept =
        relative.size() - static_cast<std::size_t>(kOutlierShare * double(relative.size()));
    std::nth_element(relative.begin(), relative.begin() + static_cast<std::ptrdiff_t>(kept - 1),
                     relative.end());
    errors.relMseTrimmed =
        std::accumulate(relative.begin(), relative.begin() + static_cast<std::ptrdiff_t>(kept),
                        0.0) /
        (3.0 * double(kept));

    const auto rank = static_cast<std::size_t>(std::ceil(0.95 * double(differences.size()))) - 1;
    std::nth_element(differences.begin(), differences.begin() + static_cast<std::ptrdiff_t>(rank),
                     differences.end());
    errors.p95 = differences[rank];
    return errors;
}

double closedGap(double error, double errorOff, double floor) {
    const double noise = std::max(floor, kMinNoise);
    const auto decades = [noise](double value) {
        return std::log10(std::max(value, noise)) - std::log10(noise);
    };
    const double gap = decades(errorOff), remaining = decades(error);
    if (!(gap > 0.0)) return 1.0;
    // Bounded, because the gap may be close to 0.
    return std::clamp(1.0 - remaining / gap, -100.0, 1.0);
}

namespace {

// Ten even steps of matplotlib's map "magma" (van der Walt and Smith, CC0), sRGB codes.
constexpr glm::u8vec3 kSteps[] = {{0x00, 0x00, 0x04}, {0x18, 0x0f, 0x3e}, {0x45, 0x10, 0x77},
                                  {0x72, 0x1f, 0x81}, {0x9f, 0x2f, 0x7f}, {0xcd, 0x40, 0x71},
                                  {0xf1, 0x60, 0x5d}, {0xfd, 0x95, 0x67}, {0xfe, 0xc9, 0x8d},
                                  {0xfc, 0xfd, 0xbf}};
constexpr glm::u8vec3 kNotFinite{0, 255, 255};  // not in the colour map

}  // namespace

glm::u8vec3 falseColour(double t) {
    constexpr int kLast = static_cast<int>(std::size(kSteps)) - 1;
    const double position = (t > 0.0 ? std::min(t, 1.0) : 0.0) * kLast;  // NaN is 0
    const int step = std::min(static_cast<int>(position), kLast - 1);
    const glm::dvec3 color =
        glm::mix(glm::dvec3(kSteps[step]), glm::dvec3(kSteps[step + 1]), position - step);
    return glm::u8vec3(color + 0.5);
}

Image errorPicture(const Image& actual, const Image& reference, double maxError) {
    const ComparedPair pair = comparedPair(actual, reference, nullptr, PixelType::float32);
    const double floor =
        std::max(kRelativeFloor * linearErrors(actual, reference).meanReference, 1e-9);
    Image picture = makeImage(actual.width, actual.height, 3, PixelType::srgb8);
    for (std::size_t i = 0; i < pair.counted.size(); ++i) {
        double difference = 0.0, radiance = 0.0;
        for (std::size_t c = 0; c < 3; ++c) {
            difference += std::abs(pair.actual[c].values[i] - pair.reference[c].values[i]) / 3.0;
            radiance += std::max(pair.reference[c].values[i], 0.0) / 3.0;
        }
        const glm::u8vec3 color =
            pair.counted[i]
                ? falseColour(difference / (radiance + floor) / std::max(maxError, 1e-9))
                : kNotFinite;
        std::copy_n(&color.x, 3, picture.bytes() + 3 * i);
    }
    return picture;
}

Image displayed(const Image& linear, ToneMap curve, float exposureFactor) {
    if (linear.type != PixelType::float32 || linear.channels < 3) {
        throw std::runtime_error("tone mapping requires float32 with 3 or 4 channels");
    }
    Image result = makeImage(linear.width, linear.height, 3, PixelType::float32);
    const std::size_t pixels = std::size_t(linear.width) * linear.height;
    for (std::size_t i = 0; i < pixels; ++i) {
        const float* from = linear.floats() + i * linear.channels;
        const glm::vec3 radiance = glm::vec3(from[0], from[1], from[2]) * exposureFactor;
        const glm::vec3 code = glsl::srgbFromLinear(toneMapped(radiance, curve));
        std::copy_n(&code.x, 3, result.floats() + 3 * i);
    }
    return result;
}

Image quantised(const Image& image) {
    if (image.type != PixelType::float32) {
        throw std::runtime_error("rounding to 8 bits requires a float image");
    }
    Image result = makeImage(image.width, image.height, image.channels, PixelType::srgb8);
    for (std::size_t i = 0; i < result.data.size(); ++i) {
        const float x = image.floats()[i];
        const float code = x > 0.0f ? std::min(x, 1.0f) : 0.0f;  // NaN becomes 0
        result.bytes()[i] = static_cast<std::uint8_t>(255.0f * code + 0.5f);
    }
    return result;
}

double psnr(const Image& actual, const Image& reference, const Mask* mask) {
    const ComparedPair pair = comparedPair(actual, reference, mask);
    double squares = 0.0;
    for (std::size_t i = 0; i < pair.counted.size(); ++i) {
        if (!pair.counted[i]) continue;
        const glm::dvec3 d = clampedPixel(pair.actual, i) - clampedPixel(pair.reference, i);
        squares += glm::dot(d, d);
    }
    if (squares <= 0.0) return kMaxDecibels;
    return std::min(10.0 * std::log10(3.0 * double(pair.pixels) / squares), kMaxDecibels);
}

double ssim(const Image& actual, const Image& reference, const Mask* mask) {
    ComparedPair pair = comparedPair(actual, reference, mask);
    if (pair.pixels == 0) return 1.0;
    const Layer map = similarity(luma(pair.actual), luma(pair.reference));
    excludeBorder(pair);
    return meanOf(map, pair);
}

double decibels(const Image& actual, const Image& reference, const Mask* mask) {
    constexpr double kMax = 35215.0;  // of two colours, as published
    const ComparedPair pair = comparedPair(actual, reference, mask);
    double squares = 0.0;
    for (std::size_t i = 0; i < pair.counted.size(); ++i) {
        if (!pair.counted[i]) continue;
        const glm::dvec3 d =
            255.0 * (clampedPixel(pair.actual, i) - clampedPixel(pair.reference, i));
        const double y = glm::dot(glm::dvec3(0.29889531, 0.58662247, 0.11448223), d);
        const double in = glm::dot(glm::dvec3(0.59597799, -0.27417610, -0.32180189), d);
        const double quadrature = glm::dot(glm::dvec3(0.21147017, -0.52261711, 0.31114694), d);
        const double distance = 0.5053 * y * y + 0.299 * in * in + 0.1957 * quadrature * quadrature;
        squares += distance * distance;
    }
    if (squares <= 0.0) return -kMaxDecibels;
    return std::max(10.0 * std::log10(std::sqrt(squares / double(pair.pixels)) / kMax),
                    -kMaxDecibels);
}

double flip(const Image& actual, const Image& reference, const Mask* mask, double pixelsPerDegree) {
    const ComparedPair pair = comparedPair(actual, reference, mask);
    const Image map = flipMap(actual, reference, pixelsPerDegree);
    double sum = 0.0;
    for (std::size_t i = 0; i < pair.counted.size(); ++i) {
        if (pair.counted[i]) sum += map.floats()[i];
    }
    return pair.pixels ? sum / double(pair.pixels) : 0.0;
}

DisplayedErrors displayedErrors(const Image& actual, const Image& reference, const Mask* mask,
                                double pixelsPerDegree) {
    const ComparedPair pair = comparedPair(actual, reference, mask);
    return {.pixels = pair.pixels,
            .nonFinite = pair.nonFinite,
            .psnr = psnr(actual, reference, mask),
            .ssim = ssim(actual, reference, mask),
            .flip = flip(actual, reference, mask, pixelsPerDegree),
            .decibels = decibels(actual, reference, mask)};
}

}  // namespace clerestory
