// Which triangles of a mesh lie in one plane and are worth a mirror of their own.
#pragma once

#include "scene/scene.h"

#include <array>
#include <span>

namespace clerestory {

struct FlatGroup {
    std::vector<std::uint32_t> triangles;  // ascending places in the list that was searched
    Plane plane;                           // its front is the side that sees them wound
                                           // counter-clockwise
    double area = 0.0;
};

inline constexpr std::size_t kMaxFlatParts = 12;  // per mesh

// A part's share of the largest face of the mesh's box, below which nobody would miss its mirror.
inline constexpr double kMinFlatShare = 0.02;

// Largest first. Scale-free and the same in any orientation (erratum P4): in a group every corner
// is within 1e-4 of the group's diagonal of its plane, every triangle's normal within 1 degree of
// its normal (both but for what float positions cannot say), and it is not a line. The plane is
// that of the triangles, whatever the vertex normals are (P5); but a facet most of whose vertex
// normals lean gently away from it belongs to something round, and is no group.
std::vector<FlatGroup> flatGroups(std::span<const Vertex> vertices,
                                  std::span<const std::array<std::uint32_t, 3>> triangles);

}  // namespace clerestory
