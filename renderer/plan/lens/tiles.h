// A frame of a lens that no projection matrix describes is assembled from perspective pictures, its
// tiles: one about the axis where that shows the whole frame, otherwise those of the six faces of a
// cube that it shows. Tiles overlap, and their weights pass from one to the next across the
// overlap. Pure.
#pragma once

#include "plan/lens/lens.h"

#include <string>
#include <vector>

namespace clerestory {

struct LensTile {
    std::string name;  // "front", "left", ...
    glm::dmat3 cameraFromTile{1.0};
    Intrinsics pinhole;  // of its picture, pixelCenter half
    std::uint32_t width = 1, height = 1;
    double share = 0.0;  // of the frame's pixels, about
    bool operator==(const LensTile&) const = default;
};

// The tiles that show the frame, the largest share first; empty if no pixel has a direction. No
// texel is larger than a pixel in any direction, except that pixels less than half as wide as long
// count as half: those at a pole have no width. `density`: texels for each pixel along an edge, at
// least; a cube lens has one for one. At most kMaxTileTexels for each pixel of the frame.
std::vector<LensTile> tilesOf(const Lens& lens, double density = 1.0);
inline constexpr double kMaxTileTexels = 24.0;

// Where the pixels of the frame read a tile.
struct TileLookups {
    // Part of the frame that contains all pixels that read it, from the lower left corner.
    std::uint32_t x = 0, y = 0, width = 0, height = 0;
    // For each pixel of the rectangle, lower row first: x and y in texels from the tile's lower
    // left corner, its weight among the tiles (0: it does not read this one), and the factor from
    // depth in the tile to depth in the frame.
    std::vector<glm::vec4> texels;
};
// Of each tile. blend: the weights of a pixel add up to 1; otherwise, and for a cube lens, whose
// faces are apart, one tile has all of it.
std::vector<TileLookups> lookupsOf(const Lens& lens, const std::vector<LensTile>& tiles,
                                   bool blend);

}  // namespace clerestory
