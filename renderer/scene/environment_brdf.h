// The two numbers of the split sum: a specular lobe of reflectance f0 returns f0 * A + B of a
// uniform environment (single scattering, GGX with height-correlated Smith, Schlick's Fresnel).
#pragma once

#include <glm/glm.hpp>

#include <cstdint>
#include <vector>

namespace clerestory {

// A at one place of the table is .x, B is .y. nDotV and roughness in 0..1; alpha = roughness^2.
glm::vec2 environmentBrdf(float nDotV, float roughness);

// size * size entries, row by row: column i stands for nDotV = (i / (size - 1))^2, row j for
// roughness j / (size - 1). So the edges are exact, grazing angles have many columns, and a bilinear
// lookup goes through environmentBrdfCoordinate() of optics.glsl with clamping to the edge. size is
// at least 2.
std::vector<glm::vec2> environmentBrdfTable(std::uint32_t size);

}  // namespace clerestory
