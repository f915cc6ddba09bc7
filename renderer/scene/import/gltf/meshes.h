// glTF 2.0 primitives -> meshes of the scene, in their bind pose where they are skinned or morphed.
#pragma once

#include "scene/import/base/types.h"
#include "scene/import/gltf/document.h"
#include "scene/mesh_builder.h"

#include <map>
#include <vector>

namespace clerestory {

// How a skinned or morphed mesh stands at rest. Empty: as the primitive is written.
struct RestPose {
    // Per joint: its node's transform, relative to where the mesh will stand, * its inverse bind.
    std::vector<glm::dmat4> fromBind;
    std::vector<double> morphWeights;
};

// What moves a mesh, as places in the scene's lists.
struct Movers {
    Index skin = kNone;
    Index weights = kNone;
    bool any() const { return skin != kNone || weights != kNone; }
};

class GltfMeshes {
public:
    // The scene's last material must be glTF's default one.
    GltfMeshes(GltfDocument& document, Scene& scene, const ImportLimits& limits);

    // One scene mesh for each primitive with triangles; made once.
    const std::vector<Index>& meshes(Index gltfMesh);
    // The same in a pose of its own, so never shared.
    std::vector<Index> posedMeshes(Index gltfMesh, const RestPose& pose);
    // The same, with a Deformation each. Their vertices are not at rest before finishMotion().
    std::vector<Index> deformingMeshes(Index gltfMesh, const RestPose& pose, const Movers& movers);

private:
    Index add(const Json& primitive, const std::string& name, const RestPose& pose,
              const Movers& movers);
    void addDeformation(const Json& primitive, std::size_t fileVertices,
                        const std::vector<std::uint32_t>& fileVertexOf, const Movers& movers,
                        bool flatNormals);
    void addInfluences(const Json& attributes, std::size_t fileVertices,
                       const std::vector<std::uint32_t>& fileVertexOf, Deformation& deformation);
    void addTargets(const Json& primitive, std::size_t fileVertices,
                    const std::vector<std::uint32_t>& fileVertexOf, Deformation& deformation);
    std::vector<std::uint32_t> triangles(const Json& primitive, std::size_t vertexCount,
                                         const std::string& name);
    Numbers attribute(const Json& attributes, const char* key, std::size_t count,
                      const std::string& name);
    void morph(const Json& primitive, const RestPose& pose, MeshDraft& draft);
    void skin(const Json& attributes, const RestPose& pose, MeshDraft& draft);

    GltfDocument& document_;
    Scene& scene_;
    ImportLimits limits_;
    std::uint64_t triangles_ = 0;
    Index defaultMaterial_;
    std::map<Index, std::vector<Index>> known_;
};

}  // namespace clerestory
