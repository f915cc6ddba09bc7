// Adds meshes to a scene: drops and counts invalid triangles, lines and points, generates missing
// normals and tangents, divides the mesh into spatial clusters.
#pragma once

#include "scene/scene.h"

#include <array>
#include <span>

namespace clerestory {

struct MeshDraft {
    std::string name;
    Index material = 0;
    std::vector<Vertex> vertices;
    Primitive primitive = Primitive::triangles;
    std::vector<std::uint32_t> indices;  // into `vertices`; may be out of range
    bool hasNormals = false;
    bool hasTangents = false;
    bool hasTexCoords = false;
    bool deforms = false;  // no flat parts
};

// Drops triangles that are degenerate, out of range or not finite. Generates normals (weighted by
// area, smooth) and tangents (from texCoord0, or any perpendicular) where the draft has none, or
// zero or non-finite ones; tangents follow the axes of the material's normal texture. Finds flat
// parts and makes clusters of at most kClusterPrimitives. Lines and points keep the normals that
// they have; without they are not lit. Each kind of repair adds one ImportWarning with a count.
// Returns kNone, with a warning, if nothing is left.
Index addMesh(Scene& scene, MeshDraft draft);
// The same. Sets `sources` to the draft's vertex index of each vertex that was appended to the
// scene.
Index addMesh(Scene& scene, MeshDraft draft, std::vector<std::uint32_t>& sources);

// Repeats the last index up to a multiple of 3, so that triangles after lines or points begin at
// one.
void endTriple(std::vector<std::uint32_t>& indices);

// Adds a node and returns its index.
Index addNode(Scene& scene, std::string name, const glm::dmat4& parentFromLocal = glm::dmat4(1.0),
              Index parent = kNone);

// Draws the mesh at the node, with the mesh's material unless another one is given.
void addInstance(Scene& scene, Index node, Index mesh, Index material = kNone);

// Triangles of a mesh that lie in one plane and are large enough for a planar mirror.
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
