// Closed bodies of two-sided materials. Exporters mark most materials as two-sided, so that the
// side of a face does not tell whether a ray begins inside of something: below a box that stands on
// a floor.
#pragma once

#include "light/bake_input.h"
#include "light/faces.h"
#include "rays/triangle_tree.h"

#include <vector>

namespace clerestory::light {

// For each instance of the scene: its triangles close a body that has an inside which nothing
// shows. They are static and plain and do not emit, each edge belongs to two of them with opposite
// directions, they face outwards, and the box around them holds no light and no smaller instance:
// it may be a room. faces: of the tree. origin: of its triangles, world.
std::vector<bool> closedBodies(const BakeInput& input, const rays::TriangleTree& tree,
                               const std::vector<Face>& faces, const glm::dvec3& origin);

}  // namespace clerestory::light
