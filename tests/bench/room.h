// The scene for memory and speed measurements: 197k triangles, mirror floor, chrome torus knot,
// glass ball and pane, three lights, no textures.
#pragma once

#include <filesystem>

namespace clerestory::bench {

// Writes room.gltf and room.bin into the folder; returns the former. Throws std::runtime_error when
// that fails.
std::filesystem::path writeRoom(const std::filesystem::path& folder);

}  // namespace clerestory::bench
