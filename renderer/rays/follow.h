// Follows rays through a scene on the processor, with the same formulae as the shaders: the
// includes of shaders/ are compiled as C++.
//
//     TriangleTree tree; tree.setStill(...);
//     follow({.tree = tree, ...}, starts, ways, radiance);
//
// Pure: the same arguments give the same bytes for any number of threads. Does not use OpenGL.
#pragma once

#include "rays/cube_map.h"
#include "rays/record.h"
#include "rays/triangle_tree.h"
#include "scene/geometry.h"

#include <glm/glm.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clerestory::rays {

// What rays meet and the light there. The rows are those of the shaders' tables
// (passes/ray_tables.h). The members must outlive the call.
struct Surroundings {
    const TriangleTree& tree;
    std::span<const Vertex> vertices;        // Scene::vertices, in the pose
    std::span<const std::uint32_t> indices;  // Scene::indices
    std::span<const glm::vec4> instances;    // TRACE_INSTANCE_ROWS each
    std::span<const glm::vec4> materials;    // TRACE_MATERIAL_ROWS each, then textures
    std::size_t firstTextureRow = 0;
    std::span<const std::byte> texels;  // RGBA, 8 bits each
    std::span<const glm::vec4> lights;  // the light table of the pass
    const CubeMap& environment;         // prefiltered by roughness
    float environmentIntensity = 1.0f;
    std::span<const glm::vec2> brdf;  // environmentBrdfTable(brdfSize)
    std::uint32_t brdfSize = 0;
    glm::vec3 eye{0.0f};  // from the tree's origin, world axes
    glm::mat3 worldFromEye{1.0f};
    std::uint32_t bounces = 0;      // maximum of reflections and refractions of a ray
    std::uint32_t hitFeatures = 0;  // union of the features of all surfaces
    float leastShare = 0.0f;        // of a ray in its pixel, below which it ends
};

// Not every pixel needs a path of its own: one in `stride` x `stride` has one, and the others have
// the mean of neighbours whose paths met the same surfaces and brought nearly the same light.
struct Density {
    std::uint32_t stride = 1;  // power of two; 1: every pixel follows its ray
    // Largest difference of neighbours' radiance times its share, relative to the light of the
    // pixel.
    float contrast = 0.0f;
};

// Memory that calls of follow() share, so that they need not allocate it.
struct Path {
    float radiance[3];
    std::uint32_t surfaces;  // hash of those that the path met; 0: there is no ray
};
using Scratch = std::vector<Path>;

// The rays of an earlier call and their paths.
struct Earlier {
    std::span<const Start> starts;
    std::span<const Path> paths;
};

// Adds to each pixel's radiance (rgb) that along its ray times its share. starts, ways and radiance
// have one element for each pixel, in rows of `width`. Returns the number of paths followed.
//
// earlier: of the same pixels, such as those of their other samples; a ray that starts as one of
// them did has its path.
std::uint64_t follow(const Surroundings& surroundings, const Density& density, std::uint32_t width,
                     std::span<const Start> starts, std::span<const Way> ways,
                     std::span<const Earlier> earlier, std::span<glm::vec4> radiance,
                     Scratch& scratch);

}  // namespace clerestory::rays
