// Two pictures made ready to be compared: one layer of doubles a channel, what does not count told
// apart, and filters over layers. For the measures alone.
#pragma once

#include "measures/mask.h"

#include <array>
#include <span>
#include <vector>

namespace clerestory {

struct Layer {
    std::uint32_t width = 0, height = 0;
    std::vector<double> values;  // row by row
};
using Layers = std::array<Layer, 3>;  // red, green, blue, or what a space has in their place

struct ComparedPair {
    Layers actual, reference;           // 0 in both where either is not finite
    std::vector<std::uint8_t> counted;  // a pixel: inside the mask and finite in both
    std::uint64_t pixels = 0;           // counted
    std::uint64_t nonFinite = 0;        // inside the mask, but not finite
};

// Bytes become 0..1, floats stay as they are. Throws std::runtime_error unless both pictures and
// the mask have one size, and both the type (any: the same or not) and 3 or 4 channels.
ComparedPair comparedPair(const Image& actual, const Image& reference, const Mask* mask);
ComparedPair comparedPair(const Image& actual, const Image& reference, const Mask* mask,
                          PixelType type);

// The mean of a layer over the pixels that count; 0 when none does.
double meanOf(const Layer& layer, const ComparedPair& pair);

// Weights of exp(-x^2 / (2 sigma^2)) at -radius .. radius, with the sum 1. sigma > 0.
std::vector<double> gaussian(double sigma, int radius);

// Filtered along the rows, then along the columns, by an odd number of weights each; beyond its
// border a layer goes on as its last value.
Layer filtered(const Layer& layer, std::span<const double> alongX, std::span<const double> alongY);

}  // namespace clerestory
