// Deforming meshes: morph targets first, then a skin (glTF 2.0, sections 3.7.2.2 and 3.7.3).
// Evaluated on the CPU once for each pose, so that views, rays and the reference use the same
// vertices.
//
// Does not: depend on time (animation/clip.h), upload to the GPU.
#pragma once

#include "scene/bounds.h"
#include "scene/material.h"
#include "scene/vertex.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace clerestory {

// The attributes of a vertex that a deformation changes.
struct BaseVertex {
    glm::vec3 position{0.0f};
    glm::vec3 normal{0.0f, 0.0f, 1.0f};
    glm::vec4 tangent{1.0f, 0.0f, 0.0f, 1.0f};
};

struct Skin {
    std::vector<Index> joints;              // nodes
    std::vector<glm::dmat4> jointFromMesh;  // one for each: the inverse bind matrices
};

// The weight of a joint for a vertex.
struct Influence {
    std::uint32_t joint = 0;  // in Skin::joints
    float share = 0.0f;       // the shares of a vertex add up to 1
};

// The offsets of a morph target, at weight 1, for a vertex.
struct MorphDelta {
    std::uint32_t vertex = 0;  // from 0 within the mesh
    glm::vec3 position{0.0f}, normal{0.0f}, tangent{0.0f};
};

// Each skin and each set of weights has a separate mesh. The node of a skinned mesh is a root at
// the world's origin, or translated to near the joints; vertices are relative to it.
struct Deformation {
    Index mesh = 0;
    std::uint32_t firstVertex = 0;  // in Scene::vertices, which has the rest pose
    std::vector<BaseVertex> base;   // as in the file, mesh space
    Index skin = kNone;             // in Scene::skins
    Index weights = kNone;          // in Scene::morphWeights
    std::uint32_t perVertex = 0;    // influences of each vertex; 0 without a skin
    std::vector<Influence> influences;
    std::vector<std::uint32_t>
        firstDelta;  // of each target in `deltas`, then the end; may be empty
    std::vector<MorphDelta> deltas;
    bool flatNormals = false;  // the file has no normals: one per triangle
};

// A deforming mesh in one pose.
struct DeformedMesh {
    std::uint32_t firstVertex = 0;
    std::vector<Vertex> vertices;
    Bounds bounds;                 // mesh space
    std::vector<Bounds> clusters;  // one for each cluster of the mesh
    std::uint64_t hash = 0;        // of the vertices
};

// Writes the deformed vertices to `out`: positions and directions from deformation.base, all other
// attributes from `rest`, which has the same size. The results are finite.
// weights: one for each target. worldFromJointBind: for each joint of the skin, its node's
// transform times its jointFromMesh.
void deform(const Deformation& deformation, std::span<const double> weights,
            std::span<const glm::dmat4> worldFromJointBind, std::span<const Vertex> rest,
            std::vector<Vertex>& out);

// Sets the normals of each triangle's three vertices, which no other triangle shares. `first` is
// subtracted from each index into `vertices`.
void flattenNormals(std::span<const std::uint32_t> indices, std::uint32_t first,
                    std::span<Vertex> vertices);

}  // namespace clerestory
