// A ray that starts from a pixel, as shaders/include/ray_record.glsl writes it.
#pragma once

#include <glm/glm.hpp>

#include <cstdint>

namespace clerestory::rays {

// Two half floats in an integer, as packHalf2x16() of GLSL.
using Halves = std::uint32_t;

struct Start {
    float position[3];  // metres from the origin of the TriangleTree, world axes
    Halves cone;        // of the pixel: slope, negative if it narrows; log2 of the width in metres
    // The shader writes 0 where no ray starts.
    bool present() const { return (cone & 0xffffu) != 0; }
    bool operator==(const Start&) const = default;
};
struct Way {
    float octahedral[2];   // direction, eye space's axes
    Halves shareRedGreen;  // of the ray's radiance in the pixel
    Halves shareBlueLobe;  // the blue share; slope of the cone of a rough surface, negative for a
                           // ray through one face of a body
};
static_assert(sizeof(Start) == 16 && sizeof(Way) == 16);

// The same, decoded.
struct RecordedRay {
    glm::vec3 start, along, share;  // along: eye space's axes
    float width, pixel, lobe;       // of its cone: metres, and slopes
    bool intoBody;                  // through one face of a body; else through a pane
};
enum class Ray { mirrored, transmitted };

// Whether the lobe is rough, so that several paths differ from one: not that of a mirror with a
// roughness below 0.1, and of glass that blurs as little.
inline bool isRough(const RecordedRay& ray) {
    constexpr float kLeastLobe = 0.02f;
    return ray.lobe >= kLeastLobe;
}

// How many paths share a lobe that is rough; a smooth one has one path.
struct Lobe {
    std::uint32_t paths = 1;    // 1..16
    std::uint32_t pattern = 0;  // selects the sampled directions of the lobe; differs by pixel
};
struct RayWithLobe {
    RecordedRay ray;
    Lobe lobe;
};

}  // namespace clerestory::rays
