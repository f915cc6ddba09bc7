// Adds meshes to a scene: drops and counts invalid triangles, generates missing normals and
// tangents, divides the mesh into spatial clusters.
#pragma once

#include "scene/scene.h"

namespace clerestory {

struct MeshDraft {
    std::string name;
    Index material = 0;
    std::vector<Vertex> vertices;
    std::vector<std::uint32_t> indices;  // of triangles, into `vertices`; may be out of range
    bool hasNormals = false;
    bool hasTangents = false;
    bool hasTexCoords = false;
    bool deforms = false;  // no flat parts
};

// Drops triangles that are degenerate, out of range or not finite. Generates normals (weighted by
// area, smooth) and tangents (from texCoord0, or any perpendicular) where the draft has none, or
// zero or non-finite ones. Finds flat parts and makes clusters of at most kClusterTriangles. Each
// kind of repair adds one ImportWarning with a count. Returns kNone, with a warning, if no triangle
// is left.
Index addMesh(Scene& scene, MeshDraft draft);
// The same. Sets `sources` to the draft's vertex index of each vertex that was appended to the
// scene.
Index addMesh(Scene& scene, MeshDraft draft, std::vector<std::uint32_t>& sources);

// Adds a node and returns its index.
Index addNode(Scene& scene, std::string name, const glm::dmat4& parentFromLocal = glm::dmat4(1.0),
              Index parent = kNone);

// Draws the mesh at the node, with the mesh's material unless another one is given.
void addInstance(Scene& scene, Index node, Index mesh, Index material = kNone);

}  // namespace clerestory
