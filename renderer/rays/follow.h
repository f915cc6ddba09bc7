// Follows the recorded rays of a picture through a scene on the processor.
//
//     TriangleTree tree; tree.setStill(...);
//     follow({.tree = tree, ...}, {}, {.kind = Ray::mirrored, .width = 640, ...}, radiance, paths);
//
// Pure: the same arguments give the same bytes for any number of threads. Does not use OpenGL.
#pragma once

#include "rays/path.h"
#include "rays/record.h"
#include "rays/surroundings.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace clerestory::rays {

// One pixel in each block of `stride` x `stride` has its own path. The others take the mean of
// neighbours whose paths hit the same surfaces and have nearly the same radiance, or read the
// environment between neighbours whose rays leave the scene at once. A mirrored ray must also lie
// between those of the neighbours. Else they have a path of their own.
struct Density {
    std::uint32_t stride = 1;  // power of two; 1: every pixel follows its ray
    // Power of two, at most `stride`. Pixels between those of every `finest`-th column and row take
    // the mean even if these neighbours hit different surfaces, provided that all their rays start
    // on the same surface in similar directions.
    std::uint32_t finest = 1;
    // Largest difference of neighbours' radiance times its share, relative to the light of the
    // pixel: where they are more than one pixel away, and next to it.
    float contrast = 0.0f, contrastNextTo = 0.0f;
    float contrastBetween = 0.0f;  // the same for pixels between those of `finest`
    // Paths of a rough lobe, 1..16. Above 1 a rough pixel also takes the mean of its neighbours
    // whose lobes show nearly the same part of the scene.
    std::uint32_t lobePaths = 1;
};

// Memory that calls of follow() reuse to avoid allocations.
using Scratch = std::vector<Path>;

// One ray of each pixel, in rows of `width`.
struct Records {
    Ray kind = Ray::mirrored;
    std::uint32_t width = 0;
    std::span<const Start> starts;
    std::span<const Way> ways;
};

// Adds to each pixel's radiance (rgb) that along its ray times its share. Returns the number of
// paths followed.
std::uint64_t follow(const Surroundings& surroundings, const Density& density,
                     const Records& records, std::span<glm::vec4> radiance, Scratch& scratch);

}  // namespace clerestory::rays
