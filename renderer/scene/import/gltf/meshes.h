// glTF 2.0 primitives -> meshes of the scene.
#pragma once

#include "scene/import/base/types.h"
#include "scene/import/gltf/document.h"
#include "scene/mesh_builder.h"

#include <map>
#include <vector>

namespace clerestory {

// The rest pose of a skinned or morphed mesh. Empty: as in the primitive.
struct RestPose {
    // For each joint: its transform relative to the mesh's node, times its inverse bind matrix.
    std::vector<glm::dmat4> fromBind;
    std::vector<double> morphWeights;
};

// What animates a mesh: indices in Scene::skins and Scene::morphWeights.
struct MeshAnimation {
    Index skin = kNone;
    Index weights = kNone;
    bool any() const { return skin != kNone || weights != kNone; }
};

class GltfMeshes {
public:
    // The scene's last material must be glTF's default material.
    GltfMeshes(GltfDocument& document, Scene& scene, const ImportLimits& limits);

    // One mesh for each primitive with triangles; made once and shared.
    const std::vector<Index>& meshes(Index gltfMesh);
    // The same in a given pose; not shared.
    std::vector<Index> posedMeshes(Index gltfMesh, const RestPose& pose);
    // The same, with a Deformation each. finishMotion() sets their rest pose.
    std::vector<Index> deformingMeshes(Index gltfMesh, const RestPose& pose,
                                       const MeshAnimation& animation);

private:
    Index add(const Json& primitive, const std::string& name, const RestPose& pose,
              const MeshAnimation& animation);
    void addDeformation(const Json& primitive, std::size_t fileVertices,
                        const std::vector<std::uint32_t>& fileVertexOf,
                        const MeshAnimation& animation, bool flatNormals);
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
