// The split-sum approximation: a specular lobe of reflectance f0 reflects f0 * A + B of a uniform
// environment (single scattering, GGX with height-correlated Smith, Schlick's Fresnel).
#pragma once

#include <glm/glm.hpp>

#include <cstdint>
#include <vector>

namespace clerestory {

// A is .x, B is .y. nDotV and roughness in 0..1; alpha = roughness^2.
glm::vec2 environmentBrdf(float nDotV, float roughness);

// size * size entries, row by row: column i has nDotV = (i / (size - 1))^2, row j has roughness
// j / (size - 1). The edges are exact and grazing angles have more columns. Sample bilinearly,
// clamped to the edge, at environmentBrdfCoordinate() of optics.glsl. size is at least 2.
std::vector<glm::vec2> environmentBrdfTable(std::uint32_t size);

}  // namespace clerestory
