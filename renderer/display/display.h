// Tone mapping and edge filter on the processor, for software drivers: a loop over rows takes about
// a tenth of the time of a full-screen pass on such a driver. tone_map.frag and edge_filter.frag do
// the same for hardware; both give the same pictures except for rounding.
//
//     display::Picture picture;
//     display::toneMap({width, height, halves}, ToneMap::neutral, exposureFactor, true, picture);
//     Image smoothed;
//     display::smoothEdges(picture, false, smoothed);
//
// Results do not depend on the number of threads. No function throws except std::bad_alloc.
#pragma once

#include "image/image.h"
#include "plan/request/tone_map.h"

#include <cstdint>
#include <span>
#include <vector>

namespace clerestory::display {

// Linear radiance as OpenGL stores it: four halves for each pixel, red in the lowest bits of an
// element, bottom row first. Any value is allowed, also NaN and infinity; alpha is not read.
struct Radiance {
    std::uint32_t width = 0, height = 0;
    std::span<const std::uint64_t> pixels;  // width * height
};

// A display picture, and how bright its pixels look.
struct Picture {
    Image image;                           // srgb8, 4 channels, opaque, top row first
    std::vector<std::uint8_t> brightness;  // of each pixel: square root of its luminance, 255: 1
    bool compressed = false;               // the tone curve compresses bright colours
};

// exposureFactor: positive, multiplies the radiance. The brightness is computed for smoothEdges()
// only. Memory of an earlier picture of this size is used again.
void toneMap(const Radiance& radiance, ToneMap curve, float exposureFactor, bool brightness,
             Picture& picture);

// Blends pixels on edges with their surroundings along the edge; after an idea of Lottes (FXAA,
// 2009). The picture has a brightness. ofSamples: its pixels are means of several samples, and are
// blended in part.
void smoothEdges(const Picture& picture, bool ofSamples, Image& smoothed);

}  // namespace clerestory::display
