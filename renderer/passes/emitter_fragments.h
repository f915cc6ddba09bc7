// Which part of each pixel the triangles of emitters cover; see plan/graph/emitter_coverage.h.
#pragma once

#include "plan/graph/emitter_coverage.h"
#include "scene/scene.h"

#include <cstdint>
#include <vector>

namespace clerestory {

// A triangle in a pixel.
struct EmitterFragment {
    std::uint32_t x = 0, y = 0;  // the first row is the lowest
    float share = 0.0f;          // of the pixel
    std::uint64_t places = 0;    // as PixelTriangle::placesIn(), for triangles that overlap
    bool hasCenter = false;      // whether it covers the middle, which a sample shows
    std::uint32_t emitter = 0;   // index of EmitterCoverage::emitters
    float depth = 0.0f;          // from the eye's plane, metres
    float depthRange = 0.0f;     // of the triangle
};

// Of the emitters' triangles that face the eye, in the order of emitters and triangles. Emitters
// with a large triangle have none: what is missing at their edges is not small. There are at most
// kMaxFragments; those of the last emitters are left out.
inline constexpr std::size_t kMaxFragments = 200'000;
std::vector<EmitterFragment> emitterFragments(const Scene& scene, const Pose& pose,
                                              const EmitterCoverage& work, std::uint32_t width,
                                              std::uint32_t height);

}  // namespace clerestory
