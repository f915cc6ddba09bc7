// A cube map with levels in main memory, read as a driver reads it: bilinear across edges, linear
// between levels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clerestory::rays {

class CubeMap {
public:
    CubeMap() = default;
    // faceSize: texels along an edge of level 0; each level has half the edge of the previous one.
    CubeMap(std::uint32_t faceSize, std::uint32_t levels);

    std::uint32_t levels() const { return static_cast<std::uint32_t>(levels_.size()); }
    // RGBA, first row first; faces in the order of OpenGL.
    void setFace(std::uint32_t level, std::uint32_t face, std::span<const float> rgba);
    // Call it after the last setFace().
    void joinEdges();

    // rgb along a direction of any length above 0, at a level in [0, levels - 1] (clamped).
    void sample(const float direction[3], float level, float rgb[3]) const;

private:
    struct Level {
        std::uint32_t size = 0;
        std::vector<float> texels;  // 6 faces of (size + 2)^2 RGB texels with a border
    };
    float* texel(Level& level, std::uint32_t face, int x, int y) const;

    std::vector<Level> levels_;
};

}  // namespace clerestory::rays
