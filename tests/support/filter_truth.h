// The filters on the CPU in double precision, written from their definitions, to compare the
// renderer's with.
#pragma once

#include "image/image.h"

#include <glm/glm.hpp>

#include <array>
#include <cstdint>
#include <vector>

namespace clerestory::test {

// First row on top.
struct Picture {
    int width = 0, height = 0;
    std::vector<glm::dvec3> pixels;

    Picture(int w, int h) : width(w), height(h), pixels(static_cast<std::size_t>(w) * h) {}
    // A float image with three channels.
    explicit Picture(const Image& image);
    glm::dvec3& at(int x, int y) { return pixels[static_cast<std::size_t>(y) * width + x]; }
    const glm::dvec3& at(int x, int y) const {
        return pixels[static_cast<std::size_t>(y) * width + x];
    }
    glm::dvec3 sum() const;
};

// `amount` in radians per picture height; `radius` in pixels, none when negative.
Picture twirled(const Picture& from, double amount, double radius = -1.0);

// Nine weights row by row, first row on top.
Picture convolved(const Picture& from, const std::array<double, 9>& kernel, bool repeat);

Picture glowing(const Picture& from, double threshold, double strength, double radius);

// The greatest difference of a channel, as a share of the greatest value of either.
double greatestDifference(const Picture& a, const Picture& b);

}  // namespace clerestory::test
