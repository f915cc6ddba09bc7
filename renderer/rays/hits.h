// What rays hit that end at the first surface.
#pragma once

#include <glm/glm.hpp>

#include <cstdint>

namespace clerestory::rays {

// The first surface along a ray, without holes of alpha masks, glass and blended surfaces.
struct SurfaceHit {
    bool met = false;    // else the ray leaves the scene
    bool begins = true;  // false: the ray began behind a surface that is not drawn from there
    float distance = 0.0f;
    std::uint32_t instance = 0;
    std::uint32_t face = 0;          // triangle of the TriangleTree
    std::uint32_t vertices[3] = {};  // of Surroundings::vertices
    float weights[3] = {};           // of the vertices
    glm::vec3 normal{0.0f};          // unit, eye space's axes, towards the ray's start
    glm::vec3 albedo{0.0f};          // share of uniform light that the surface sends back, 0..1
    glm::vec3 through{0.0f};         // share of it that a sheet transmits diffusely, 0..1
    glm::vec3 emitted{0.0f};         // radiance
    // Transmittance of glass and blended surfaces before the hit. 0: the ray ends in them, and only
    // `met` is known.
    glm::vec3 share{1.0f};
};

// The first surface along a ray that is drawn there and no hole.
struct PointHit {
    std::uint32_t instance = 0;
    std::uint32_t triangle = 0;  // its corners are Scene::indices[3 * triangle ...]
    bool front = true;           // it is met from its outer side
    glm::vec3 normal{0.0f};      // unit, with bumps, eye space's axes, on the side that is met
    glm::vec3 baseColor{0.0f};
};

}  // namespace clerestory::rays
