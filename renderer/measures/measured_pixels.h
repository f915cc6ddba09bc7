// The pixels that an error is measured over: masks of the pixels whose first surface shows an
// effect, and, internal to the measures, two images as layers of doubles with separable filters.
#pragma once

#include "image/image.h"
#include "plan/graph/frame_plan.h"
#include "scene/scene.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace clerestory {

struct Mask {
    std::uint32_t width = 0, height = 0;
    std::vector<std::uint8_t> inside;  // width * height; nonzero: counted
    std::uint64_t pixels() const;      // counted
};

// The frame whose `through` channel gives the masks: the same view with every effect on, and with
// techniques that the channel distinguishes, so that all accuracy settings have the same masks.
FrameRequest maskRequest(FrameRequest request);

// The mask of an effect, from the channel `through` of maskRequest(). refraction: glass;
// planarReflection: flat mirrors that show a mirrored view; environmentReflection: mirrors that
// show a captured cube, rays or the environment map; base: none of these. Empty for effects that
// the channel does not distinguish: emission (see emissionMask()),
// layers (see layersMask()) and filters. Throws
// std::runtime_error unless the image has one float channel.
Mask maskOf(const Image& through, Effect effect);

// Pixels of instances that emit, from the channel `objectId`. Throws as maskOf().
Mask emissionMask(const Image& objectIds, const Scene& scene,
                  const MaterialBindings& materials = {});
// The same for materials with layers.
Mask layersMask(const Image& objectIds, const Scene& scene, const MaterialBindings& materials = {});

// Pixels that show an instance, from the channel `objectId`. Throws as maskOf().
Mask modelMask(const Image& objectIds);

struct Layer {
    std::uint32_t width = 0, height = 0;
    std::vector<double> values;  // row by row
};
using Layers = std::array<Layer, 3>;  // red, green, blue, or the axes of another colour space

struct ComparedPair {
    Layers actual, reference;           // 0 in both if either is not finite
    std::vector<std::uint8_t> counted;  // per pixel: inside the mask and finite in both
    std::uint64_t pixels = 0;           // counted
    std::uint64_t nonFinite = 0;        // inside the mask, but not finite
};

// Bytes are scaled to 0..1; floats are unchanged. Throws std::runtime_error unless both images and
// the mask have one size, and both images have 3 or 4 channels and, in the second form, the type.
ComparedPair comparedPair(const Image& actual, const Image& reference, const Mask* mask);
ComparedPair comparedPair(const Image& actual, const Image& reference, const Mask* mask,
                          PixelType type);

// Mean of a layer over the counted pixels; 0 if there are none.
double meanOf(const Layer& layer, const ComparedPair& pair);

// Weights proportional to exp(-x^2 / (2 sigma^2)) at -radius .. radius, with sum 1. sigma > 0.
std::vector<double> gaussian(double sigma, int radius);

// Filtered along rows, then along columns, by an odd number of weights each; values beyond the
// border are those of the border.
Layer filtered(const Layer& layer, std::span<const double> alongX, std::span<const double> alongY);

}  // namespace clerestory
