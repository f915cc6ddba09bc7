// From the triangles somebody wrote to the triangles we draw: bad ones dropped and counted, missing
// normals and tangents made, cut into spatial clusters, appended to a Scene.
#pragma once

#include "scene/scene.h"

namespace clerestory {

struct MeshDraft {
    std::string name;
    Index material = 0;
    std::vector<Vertex> vertices;
    std::vector<std::uint32_t> indices;  // triangles, into `vertices`; any value may be wrong
    bool hasNormals = false;
    bool hasTangents = false;
    bool hasTexCoords = false;
    bool deforms = false;  // no part of it stays flat
};

// Drops triangles that are degenerate, out of range or non-finite; makes normals (area weighted,
// split by nothing) and tangents (from texCoord0, or any perpendicular) where the draft lacks them
// or holds non-finite or zero ones; finds its flat parts; cuts into clusters of at most
// kClusterTriangles. Each repair is one ImportWarning with a count. Returns kNone, with a warning,
// when no triangle is left.
Index addMesh(Scene& scene, MeshDraft draft);
// The same, and tells of each of the mesh's vertices, which are the scene's last, which of the
// draft's it was.
Index addMesh(Scene& scene, MeshDraft draft, std::vector<std::uint32_t>& sources);

// Adds a node and returns its index.
Index addNode(Scene& scene, std::string name, const glm::dmat4& parentFromLocal = glm::dmat4(1.0),
              Index parent = kNone);

// The mesh at the node, in the mesh's own material unless another is given.
void addInstance(Scene& scene, Index node, Index mesh, Index material = kNone);

}  // namespace clerestory
