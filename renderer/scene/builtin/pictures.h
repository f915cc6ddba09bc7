// Procedural pictures for built-in scenes: the same texels on every machine.
#pragma once

#include "scene/scene.h"

#include <functional>

namespace clerestory::pictures {

// Value noise of several octaves that repeats after `period` cells; x and y in 0..1; result 0..1.
float noise(float x, float y, int period, int octaves, std::uint32_t seed);

// A number in 0..1 that depends on nothing but its arguments.
float hash(std::uint32_t x, std::uint32_t y, std::uint32_t seed);

// Fills a picture from texel centres (u, v in 0..1, v downwards) and builds its levels. `color` is
// in the picture's own encoding: sRGB codes / 255 for ColorSpace::srgb.
Index add(Scene& scene, std::string name, std::uint32_t width, std::uint32_t height,
          ColorSpace space, const std::function<glm::vec4(float u, float v)>& color);

// One value for a whole surface: an occlusion map that keeps a room's ambient light low.
Index addConstant(Scene& scene, std::string name, float value);

}  // namespace clerestory::pictures
