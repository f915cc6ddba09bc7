// The scene as rays on the processor read it: its triangles, and the tables that hold what they are
// made of and what shines on them.
#pragma once

#include "rays/cube_map.h"
#include "rays/shadow_map.h"
#include "rays/triangle_tree.h"
#include "scene/geometry.h"

#include <glm/glm.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

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
    glm::vec3 eye{0.0f};         // from the tree's origin, world axes
    glm::vec3 towardsEye{0.0f};  // unit, world axes, of an orthographic view; else 0
    glm::mat3 worldFromEye{1.0f};
    std::uint32_t bounces = 0;      // as Accuracy::bounces
    std::uint64_t hitFeatures = 0;  // union of the features of all surfaces
    // Values of light at vertices (light/surface_light.h), SURFACE_LIGHT_ROWS of four integers
    // each; empty: the environment lights all surfaces.
    std::span<const std::uint32_t> surfaceLight = {};
    std::span<const std::uint32_t> emitters = {};  // of each value four integers more, or none
    bool shadows = false;                          // surfaces hide lights
    // What the lights see; null: rays that look to the lights find what hides them.
    const ShadowMap* shadowMap = nullptr;
    bool roundLights = false;         // a light has a radius
    std::uint32_t shadowSamples = 0;  // of the disc of a light that has a radius
    float leastShare = 0.0f;          // of a ray in its pixel, below which it ends
    // Radiance that rays see in the place of the environment if nothing has reflected them.
    std::optional<glm::vec3> background;
};

}  // namespace clerestory::rays
