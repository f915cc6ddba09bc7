// Environment maps: radiance from infinity as a linear cube map, its spherical harmonics and, for
// an outdoor sky, the sun as a separate directional light.
#pragma once

#include <glm/glm.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace clerestory {

struct Sun {
    glm::vec3 toSun{0.0f, 1.0f, 0.0f};  // unit, map space
    glm::vec3 irradiance{0.0f};         // on a surface that faces it, linear RGB
};

struct EnvironmentMap {
    std::string name;
    std::string title;
    std::uint32_t faceSize = 0;
    // Six faces in OpenGL's order (+X -X +Y -Y +Z -Z) and OpenGL's texel layout, faceSize^2 each.
    // Finite, not negative, at most 65504 (the largest half float).
    std::vector<glm::vec3> texels;
    std::optional<Sun> sun;
    // By completeMap():
    std::uint64_t contentHash = 0;
    std::array<glm::vec3, 9> harmonics{};  // diffuseHarmonics()
    std::array<float, 4> harmonicErrors{};
    float meanRadiance = 0.0f;  // over all directions, of the brightest channel
};

// Direction through the centre of a texel: OpenGL's cube face table, not normalised (max |c| is 1).
glm::vec3 cubeTexelDirection(std::uint32_t face, std::uint32_t x, std::uint32_t y,
                             std::uint32_t faceSize);

// Built-in maps.
EnvironmentMap skyEnvironment();     // clear late-afternoon sky over pale ground, with a sun
EnvironmentMap duskEnvironment();    // soft evening sky whose sun has set
EnvironmentMap studioEnvironment();  // grey room with three soft boxes
EnvironmentMap constantEnvironment(std::string name, const glm::vec3& radiance);  // furnace tests
// "sky", "dusk", "studio", "white" (1), "grey" (0.18), "black" (0); nothing for any other name.
std::optional<EnvironmentMap> builtinEnvironment(const std::string& name);
std::vector<std::string> builtinEnvironmentNames();

// From an equirectangular image, usually with width = 2 * height; the first row is +Y, the middle
// column is -Z. Non-finite and negative texels become 0, large ones 65504.
EnvironmentMap environmentFromEquirectangular(std::string name,
                                              const std::vector<glm::vec3>& texels,
                                              std::uint32_t width, std::uint32_t height);

// Irradiance divided by pi, as nine spherical-harmonic coefficients with the cosine lobe already
// included (Ramamoorthi and Hanrahan 2001): diffuse radiance = albedo * sum(c[i] * Y_i(n)). The
// constants of Y are included as well: the basis is 1, y, z, x, xy, yz, 3z^2-1, xz, x^2-y^2.
std::array<glm::vec3, 9> diffuseHarmonics(const EnvironmentMap& map);
// Their sum for a surface with this unit normal, axes of the map.
glm::vec3 harmonicsAlong(const std::array<glm::vec3, 9>& harmonics, const glm::vec3& normal);

// What nine harmonics, scaled by lobeBands() of optics.glsl, differ from the map as a lobe of GGX
// of this roughness gathers it: root of the mean square over directions, relative to the mean of
// the map. One for each of kHarmonicRoughness.
inline constexpr std::array<float, 4> kHarmonicRoughness{0.7f, 0.8f, 0.9f, 1.0f};
std::array<float, 4> harmonicErrors(const EnvironmentMap& map);
// Between them; infinite below the first. roughness: 0..1.
float harmonicError(const EnvironmentMap& map, float roughness);

// Computes what follows from the texels and the sun, after a change of either.
void completeMap(EnvironmentMap& map);

// The split-sum approximation: a specular lobe of reflectance f0 reflects f0 * A + B of a uniform
// environment (single scattering, GGX with height-correlated Smith, Schlick's Fresnel).

// A is .x, B is .y. nDotV and roughness in 0..1; alpha = roughness^2.
glm::vec2 environmentBrdf(float nDotV, float roughness);

// size * size entries, row by row: column i has nDotV = (i / (size - 1))^2, row j has roughness
// j / (size - 1). The edges are exact and grazing angles have more columns. Sample bilinearly,
// clamped to the edge, at environmentBrdfCoordinate() of optics.glsl. size is at least 2.
std::vector<glm::vec2> environmentBrdfTable(std::uint32_t size);
// The table that surfaces are shaded with, computed once; its size is kBrdfSize in lighting.glsl.
inline constexpr std::uint32_t kEnvironmentBrdfSize = 32;
const std::vector<glm::vec2>& environmentBrdfTable();

}  // namespace clerestory
