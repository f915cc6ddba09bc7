// What both importers leave to one place: numbers back in their ranges, texts that are UTF-8, nodes
// that flatten what they carry, limits of the whole scene.
#pragma once

#include "scene/import/base/types.h"
#include "scene/scene.h"

#include <string>

namespace clerestory {

// Every factor finite and within what scene/material.h promises; warns when something was changed.
void cleanMaterial(Material& material, Scene& scene);

// Valid UTF-8 without control characters, at most 200 bytes; what is wrong becomes '?'.
std::string cleanText(const std::string& text);

// Takes `triangles` from what the scene may have; throws ImportError when it has too many.
void countTriangles(std::uint64_t& total, std::uint64_t triangles, const ImportLimits& limits);

// The last step: singular instances dropped, texts cleaned, the hash set. Throws ImportError when
// there is nothing to draw or the scene is not sound.
void finishScene(Scene& scene);

}  // namespace clerestory
