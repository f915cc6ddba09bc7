// Readers of the parts of a glTF 2.0 file: materials with the KHR_materials_* extensions,
// primitives as meshes of the scene, and animations with the nodes, weights and skins that they
// animate.
#pragma once

#include "scene/import/base/types.h"
#include "scene/import/gltf/animation_pointers.h"
#include "scene/import/gltf/document.h"
#include "scene/import/textures/texture_store.h"
#include "scene/mesh_builder.h"
#include "scene/scene.h"

#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace clerestory {

class GltfMaterials {
public:
    GltfMaterials(GltfDocument& document, TextureStore& textures, Scene& scene)
        : document_(document), textures_(textures), scene_(scene) {}

    // Appends one Material for each of the file's, in order, and glTF's default material.
    void read();

private:
    Material material(const Json& json);
    void readMetallicRoughness(const Json& json, Material& m);
    void readSpecularGlossiness(const Json& json, Material& m);
    void readSpecularGlossinessTextures(const Json& json, Material& m);
    void readExtensions(const Json& json, Material& m);
    void readLayers(const Json& json, Material& m);
    TextureSlot slot(const Json& parent, const char* key, ColorSpace colorSpace);
    TextureSlot placement(const Json& json) const;
    Index texture(Index gltfTexture, ColorSpace colorSpace);
    Texture samplerOf(const Json& texture) const;
    Index imageOf(const Json& texture) const;
    ImageSource imageSource(Index gltfImage);

    GltfDocument& document_;
    TextureStore& textures_;
    Scene& scene_;
};

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
    // The scene's last material must be glTF's default material, and its variants must have names.
    GltfMeshes(GltfDocument& document, Scene& scene, const ImportLimits& limits);

    // One mesh for each primitive; made once and shared.
    const std::vector<Index>& meshes(Index gltfMesh);
    // The same in a given pose; not shared.
    std::vector<Index> posedMeshes(Index gltfMesh, const RestPose& pose);
    // The same, with a Deformation each. finishMotion() sets their rest pose.
    std::vector<Index> deformingMeshes(Index gltfMesh, const RestPose& pose,
                                       const MeshAnimation& animation);

private:
    Index add(const Json& primitive, const std::string& name, const RestPose& pose,
              const MeshAnimation& animation);
    void addVariants(const Json& primitive, Index mesh);
    void addDeformation(const Json& primitive, std::size_t fileVertices,
                        const std::vector<std::uint32_t>& fileVertexOf,
                        const MeshAnimation& animation, bool flatNormals);
    // JOINTS_n and WEIGHTS_n: four of each for a vertex.
    struct InfluenceSet {
        Numbers shares;
        std::vector<std::uint32_t> joints;
    };
    // Those that match the vertices; with a warning if there are none.
    std::vector<InfluenceSet> influenceSets(const Json& attributes, std::size_t vertices,
                                            const std::string& name);
    void addInfluences(const Json& attributes, std::size_t fileVertices,
                       const std::vector<std::uint32_t>& fileVertexOf, Deformation& deformation);
    void addTargets(const Json& primitive, std::size_t fileVertices,
                    const std::vector<std::uint32_t>& fileVertexOf, Deformation& deformation);
    void setIndices(const Json& primitive, std::size_t vertexCount, MeshDraft& draft);
    Numbers attribute(const Json& attributes, const char* key, std::size_t count,
                      const std::string& name);
    // Displacements of the tangents; without any if they do not match the vertices.
    Numbers tangentsOf(const Json& target, std::size_t vertices);
    void morph(const Json& primitive, const RestPose& pose, MeshDraft& draft);
    void skin(const Json& attributes, const RestPose& pose, MeshDraft& draft);

    GltfDocument& document_;
    Scene& scene_;
    ImportLimits limits_;
    std::uint64_t primitives_ = 0;
    Index defaultMaterial_;
    std::map<Index, std::vector<Index>> known_;
};

class GltfAnimations {
public:
    // nodeOf: the scene's node of each glTF node, kNone for nodes outside the scene. All arguments
    // must outlive the object.
    GltfAnimations(GltfDocument& document, Scene& scene, const std::vector<Index>& nodeOf)
        : document_(document), scene_(scene), nodeOf_(nodeOf) {}

    // Appends the file's clips. Invalid tracks are skipped with a warning. The targets of lights
    // and cameras are those of the file until placeTracks() is called.
    void readClips();
    // What was added for the file's lights, or cameras.
    struct PlacedPart {
        Index ofFile = 0;
        Index added = 0;         // in Scene::lights, or Scene::cameras
        LightFactors rest = {};  // of a light
    };
    void placeTracks(const std::vector<PlacedPart>& lights, const std::vector<PlacedPart>& cameras);
    // For each node of the scene whether a clip shows or hides it, or a node above it.
    std::vector<bool> nodesThatHide() const;

    // The index in Scene::morphWeights for the mesh at a glTF node; kNone if no clip animates it.
    Index weightsOf(Index gltfNode) const;
    // Whether a clip moves a joint of the skin.
    bool moves(const Json& skin) const;
    // Appends the skin to Scene::skins and returns its index.
    Index addSkin(const Json& skin);

private:
    void readClip(const Json& animation, std::size_t number);
    // Returns whether it was added.
    bool addTrack(const Json& animation, const Json& json, Clip& clip);
    std::optional<PointerTarget> targetOf(const Json& target);
    bool setTarget(Index index, Track& track);
    bool setMaterial(Index index, Track& track);
    Index movingNode(Index gltfNode);
    Index morphWeights(Index gltfNode);
    void requireFewNumbers() const;

    GltfDocument& document_;
    Scene& scene_;
    const std::vector<Index>& nodeOf_;
    std::set<std::string> names_;
    std::set<std::tuple<AnimatedProperty, Index, std::string>> movedByClip_;  // of the current clip
    std::set<std::string> unknownPointers_;
    std::map<Index, Index> movingAt_, weightsAt_;  // by node
    std::vector<bool> nodeMoves_;
    Index staticNode_ = kNone;   // in place of joints outside the scene
    std::uint64_t numbers_ = 0;  // of all channels
};

// The transform of a node that has TRS properties or a matrix.
Transform transformOf(const Json& node);

// The joints of a skin as nodes of the scene, kNone for nodes outside it, and their inverse bind
// matrices. Throws ImportError for a skin without joints.
struct GltfSkin {
    std::vector<Index> joints;
    std::vector<glm::dmat4> jointFromMesh;
};
GltfSkin gltfSkin(GltfDocument& document, const Json& skin, const std::vector<Index>& nodeOf);

// A list of indices of a glTF object.
std::vector<Index> indexList(const Json& parent, const char* key);

}  // namespace clerestory
