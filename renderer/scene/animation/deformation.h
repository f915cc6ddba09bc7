// Meshes whose vertices move: morph targets first, then a skin (glTF 2.0, sections 3.7.2.2 and
// 3.7.3). Done on the processor, once for a moment: every view, ray and reference then reads the
// same vertices.
//
// Does not: know times (animation/clip.h), upload anything.
#pragma once

#include "scene/bounds.h"
#include "scene/material.h"
#include "scene/vertex.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace clerestory {

// What a deformation changes of a vertex.
struct BaseVertex {
    glm::vec3 position{0.0f};
    glm::vec3 normal{0.0f, 0.0f, 1.0f};
    glm::vec4 tangent{1.0f, 0.0f, 0.0f, 1.0f};
};

struct Skin {
    std::vector<Index> joints;              // nodes
    std::vector<glm::dmat4> jointFromMesh;  // one for each: the inverse bind matrices
};

// How much a joint moves a vertex.
struct Influence {
    std::uint32_t joint = 0;  // into Skin::joints
    float share = 0.0f;       // of a vertex they sum up to 1
};

// What a whole morph target adds to a vertex.
struct MorphDelta {
    std::uint32_t vertex = 0;  // of the mesh's, from 0
    glm::vec3 position{0.0f}, normal{0.0f}, tangent{0.0f};
};

// A mesh of its own for each skin and each set of weights. With a skin its instances stand below a
// root that is the world, or moved straight to near the joints: vertices are relative to that.
struct Deformation {
    Index mesh = 0;
    std::uint32_t firstVertex = 0;  // in Scene::vertices, where the mesh is at rest
    std::vector<BaseVertex> base;   // as the file has it, in mesh space
    Index skin = kNone;             // in Scene::skins
    Index weights = kNone;          // in Scene::morphWeights
    std::uint32_t perVertex = 0;    // influences of each vertex; 0 without a skin
    std::vector<Influence> influences;
    std::vector<std::uint32_t> firstDelta;  // of each target in `deltas`, and the end; or empty
    std::vector<MorphDelta> deltas;
    bool flatNormals = false;  // the file has none: every triangle has its own
};

// A deforming mesh at one moment.
struct DeformedMesh {
    std::uint32_t firstVertex = 0;
    std::vector<Vertex> vertices;
    Bounds bounds;                 // mesh space
    std::vector<Bounds> clusters;  // of the mesh's clusters, in their order
    std::uint64_t hash = 0;        // of the vertices
};

// The vertices moved: positions and directions from `base`, everything else from `rest`, which are
// as many. Never anything that is not finite.
// weights: one for each target; worldFromJointBind: one for each joint of the skin, its node's
// transform times its jointFromMesh.
void deform(const Deformation& deformation, std::span<const double> weights,
            std::span<const glm::dmat4> worldFromJointBind, std::span<const Vertex> rest,
            std::vector<Vertex>& out);

// Every triangle's own normal; corners are not shared. indices: into `vertices` after `first` is
// taken from them.
void flattenNormals(std::span<const std::uint32_t> indices, std::uint32_t first,
                    std::span<Vertex> vertices);

}  // namespace clerestory
