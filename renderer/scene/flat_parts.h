// Finds the triangles of a mesh that lie in one plane and are large enough for a planar mirror.
#pragma once

#include "scene/scene.h"

#include <array>
#include <span>

namespace clerestory {

struct FlatGroup {
    std::vector<std::uint32_t> triangles;  // ascending indices into the given list
    Plane plane;                           // from its front the triangles are counter-clockwise
    double area = 0.0;
};

inline constexpr std::size_t kMaxFlatParts = 12;  // per mesh

// Smallest area of a part, relative to the largest face of the mesh's bounds.
inline constexpr double kMinFlatShare = 0.02;

// Largest first. Independent of scale and orientation (erratum P4). In a group every corner is
// within 1e-4 of the group's diagonal from the plane and every triangle's normal within 1 degree of
// the plane's, both apart from the precision of float positions; the group is not a line. The plane
// is that of the triangles and independent of vertex normals (P5). But if most vertex normals
// deviate slightly from it, the triangles belong to a curved surface and are no group.
std::vector<FlatGroup> flatGroups(std::span<const Vertex> vertices,
                                  std::span<const std::array<std::uint32_t, 3>> triangles);

}  // namespace clerestory
