// Normals of meshes that have none and whose faces share vertices, such as most of PLY: Assimp's
// aiProcess_GenSmoothNormals expects a vertex for each corner, and gives shared ones the normal of
// their last face.
//
//     addSmoothNormals(mesh, 45.0f);
#pragma once

struct aiMesh;

namespace clerestory {

// Each corner has the mean of the normals of its own face and of those at the same position that
// turn at most creaseDegrees from it, weighted by area. Vertices are repeated where normals differ.
// Changes nothing if the mesh has normals or no faces.
void addSmoothNormals(aiMesh& mesh, float creaseDegrees);

}  // namespace clerestory
