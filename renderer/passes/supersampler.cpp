#include "passes/supersampler.h"

#include "display/contrast.h"
#include "passes/targets.h"

#include <glm/gtc/packing.hpp>

#include <algorithm>
#include <cmath>

namespace clerestory {
namespace {

std::uint8_t alphaCode(std::uint64_t halves) {
    const float alpha = glm::unpackHalf1x16(static_cast<std::uint16_t>(halves >> 48));
    return static_cast<std::uint8_t>(std::clamp(alpha, 0.0f, 1.0f) * 255.0f + 0.5f);
}

}  // namespace

void Supersampler::read(const Target& picture) {
    const std::size_t pixels = std::size_t{width_} * height_;
    if (isHalf_) {
        halves_.resize(pixels);
        picture.readable().readHalves(halves_);
    } else {
        floats_.resize(4 * pixels);
        picture.readable().readFloats(floats_);
    }
}

void Supersampler::begin(const Supersampling& work, const Target& picture) {
    width_ = picture.spec().width;
    height_ = picture.spec().height;
    isHalf_ = picture.spec().format == Format::rgba16f;
    firstSamples_ = work.firstSamples;
    curve_ = work.curve;
    exposureFactor_ = work.exposureFactor;
    transparent_ = work.transparent;
    samples_ = 0;
    read(picture);
    firstHalves_ = halves_;
    firstFloats_ = floats_;
    const std::size_t pixels = std::size_t{width_} * height_;
    if (!isHalf_) {
        halves_.resize(pixels);
        for (std::size_t i = 0; i < pixels; ++i) {
            const float* rgba = floats_.data() + 4 * i;
            halves_[i] = glm::packHalf4x16({rgba[0], rgba[1], rgba[2], rgba[3]});
        }
    }
    display::toneMap({width_, height_, halves_}, curve_, exposureFactor_, false, displayed_);
    if (work.transparent) {
        for (std::size_t y = 0; y < height_; ++y) {  // the first row of `displayed_` is the top
            std::uint8_t* alpha = displayed_.image.bytes() + 4 * width_ * (height_ - 1 - y) + 3;
            for (std::size_t x = 0; x < width_; ++x, alpha += 4) {
                *alpha = alphaCode(halves_[width_ * y + x]);
            }
        }
    }
    pixels_ = display::contrastingPixels(displayed_.image, {work.leastContrast, work.share});
    for (std::uint32_t& pixel : pixels_) {
        pixel = (height_ - 1 - pixel / width_) * width_ + pixel % width_;
    }
    sums_.assign(pixels_.size(), glm::vec4(0.0f));
    ranges_.assign(pixels_.size(), Range{});
}

std::span<const float> Supersampler::chosenDepths(const Supersampling::Part& part,
                                                  std::uint32_t width, std::uint32_t height) {
    isChosen_.assign(std::size_t{width_} * height_, 0);
    for (const std::uint32_t pixel : pixels_) isChosen_[pixel] = 1;
    const auto pixelOf = [&](std::uint32_t texel, double origin, std::uint32_t pixels) {
        const double place = std::floor((texel + 0.5) / part.scale + origin);
        return static_cast<std::size_t>(std::clamp(place, 0.0, pixels - 1.0));
    };
    depths_.resize(std::size_t{width} * height);
    for (std::uint32_t y = 0; y < height; ++y) {
        const std::uint8_t* row = isChosen_.data() + width_ * pixelOf(y, part.origin.y, height_);
        float* depths = depths_.data() + std::size_t{width} * y;
        for (std::uint32_t x = 0; x < width; ++x) {
            depths[x] = row[pixelOf(x, part.origin.x, width_)] != 0 ? 0.0f : 1.0f;
        }
    }
    return depths_;
}

void Supersampler::add(const Target& picture) {
    read(picture);
    sampleHalves_.resize(pixels_.size());
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
        const std::size_t pixel = pixels_[i];
        glm::vec4 sample;
        if (isHalf_) {
            sampleHalves_[i] = halves_[pixel];
            sample = glm::unpackHalf4x16(halves_[pixel]);
        } else {
            const float* rgba = floats_.data() + 4 * pixel;
            sample = {rgba[0], rgba[1], rgba[2], rgba[3]};
            sampleHalves_[i] = glm::packHalf4x16(sample);
        }
        sums_[i] += sample;
    }
    ++samples_;
    if (samples_ <= firstSamples_) addToRanges();
}

void Supersampler::addToRanges() {
    display::toneMap({static_cast<std::uint32_t>(pixels_.size()), 1, sampleHalves_}, curve_,
                     exposureFactor_, false, displayed_);
    const std::uint8_t* codes = displayed_.image.bytes();
    for (std::size_t i = 0; i < pixels_.size(); ++i, codes += 4) {
        // Alpha of an opaque picture is a distance.
        const glm::u8vec4 code(codes[0], codes[1], codes[2],
                               transparent_ ? alphaCode(sampleHalves_[i]) : 255);
        ranges_[i].low = glm::min(ranges_[i].low, code);
        ranges_[i].high = glm::max(ranges_[i].high, code);
    }
}

void Supersampler::writeMean(std::size_t i) {
    const glm::vec4 mean = sums_[i] / static_cast<float>(samples_);
    if (isHalf_) {
        firstHalves_[pixels_[i]] = glm::packHalf4x16(mean);
    } else {
        for (int c = 0; c < 4; ++c) firstFloats_[std::size_t{4} * pixels_[i] + c] = mean[c];
    }
}

void Supersampler::endAlike(double leastDifference) {
    const int least = static_cast<int>(std::ceil(leastDifference * 255.0));
    std::size_t left = 0;
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
        const glm::ivec4 range = glm::ivec4(ranges_[i].high) - glm::ivec4(ranges_[i].low);
        if (std::max({range.r, range.g, range.b, range.a}) < least) {
            writeMean(i);
            continue;
        }
        pixels_[left] = pixels_[i];
        sums_[left] = sums_[i];
        ranges_[left] = ranges_[i];
        ++left;
    }
    pixels_.resize(left);
    sums_.resize(left);
    ranges_.resize(left);
}

void Supersampler::finish(const Target& picture) {
    for (std::size_t i = 0; i < pixels_.size(); ++i) writeMean(i);
    if (isHalf_) {
        picture.texture().uploadHalves(firstHalves_);
    } else {
        picture.texture().uploadPart({0, 0, width_, height_},
                                     std::as_bytes(std::span(firstFloats_)));
    }
}

}  // namespace clerestory
