// The scene for memory and speed measurements: 197k triangles, mirror floor, chrome torus knot,
// glass ball and pane, three lights, no textures.
#pragma once

#include <filesystem>

namespace clerestory::bench {

// Metres. What stands in the room keeps its place: edge at least 6, height at least 4.
struct RoomSize {
    float edge = 8.0f;
    float height = 4.0f;
};

// Writes room.gltf and room.bin into the folder; returns the former. Throws std::runtime_error when
// that fails.
std::filesystem::path writeRoom(const std::filesystem::path& folder, const RoomSize& size = {});

}  // namespace clerestory::bench
