// A ray that starts from a pixel, as shaders/include/ray_record.glsl writes it.
#pragma once

#include <cstdint>

namespace clerestory::rays {

struct Start {
    float place[3];  // world axes, from RaySceneTables::origin's hierarchy; metres
    std::uint32_t
        pixelWidth;  // half floats: slope of the pixel's cone, log2 of its width in metres
    // The shader writes 0 where no ray starts.
    bool present() const { return (pixelWidth & 0xffffu) != 0; }
    bool operator==(const Start&) const = default;
};
struct Way {
    float octahedral[2];       // direction, eye space's axes
    std::uint32_t shareRg;     // half floats: share of the ray's radiance in the pixel
    std::uint32_t shareBLobe;  // half floats: its blue, slope of the cone of a rough surface
};
static_assert(sizeof(Start) == 16 && sizeof(Way) == 16);

}  // namespace clerestory::rays
