// Final processing of imported scenes: clamps numbers to their ranges, makes texts valid UTF-8,
// handles singular transforms, enforces limits.
#pragma once

#include "scene/import/base/types.h"
#include "scene/scene.h"

#include <string>

namespace clerestory {

// Clamps every factor to the range in the material's field table. Adds a warning if one changed.
void cleanMaterial(Material& material, Scene& scene);

// Valid UTF-8 without control characters, at most 200 bytes. Invalid bytes become '?'.
std::string cleanText(const std::string& text);

// Adds `triangles` to `total`. Throws ImportError above the limit.
void countTriangles(std::uint64_t& total, std::uint64_t triangles, const ImportLimits& limits);

// The last step: removes singular instances, cleans texts, sets the hash. Throws ImportError if
// there is nothing to draw or the scene is invalid.
void finishScene(Scene& scene);

}  // namespace clerestory
