// Procedural textures for built-in scenes: the same texels on every machine.
#pragma once

#include "scene/scene.h"

#include <functional>

namespace clerestory::textures {

// Value noise of several octaves that repeats after `period` cells; x and y in 0..1; result 0..1.
float noise(float x, float y, int period, int octaves, std::uint32_t seed);

// A pseudo-random number in 0..1, a function of its arguments.
float hash(std::uint32_t x, std::uint32_t y, std::uint32_t seed);

// Evaluates `color` at texel centres (u, v in 0..1, v downwards) and builds the mip levels. `color`
// is in the encoding of the texture: sRGB codes / 255 for ColorSpace::srgb.
Index add(Scene& scene, std::string name, std::uint32_t width, std::uint32_t height,
          ColorSpace space, const std::function<glm::vec4(float u, float v)>& color);

// A texture of one value: an occlusion map that reduces a room's ambient light.
Index addConstant(Scene& scene, std::string name, float value);

}  // namespace clerestory::textures
