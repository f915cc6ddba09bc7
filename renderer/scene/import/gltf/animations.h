// glTF 2.0 animations -> clips, and the nodes, weights and skins that they animate.
#pragma once

#include "scene/import/gltf/document.h"
#include "scene/scene.h"

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace clerestory {

class GltfAnimations {
public:
    // nodeOf: the scene's node of each glTF node, kNone for nodes outside the scene. All arguments
    // must outlive the object.
    GltfAnimations(GltfDocument& document, Scene& scene, const std::vector<Index>& nodeOf)
        : document_(document), scene_(scene), nodeOf_(nodeOf) {}

    // Appends the file's clips. Invalid tracks are skipped with a warning.
    void readClips();

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
    bool setTarget(const Json& target, Track& track);
    Index movingNode(Index gltfNode);
    Index morphWeights(Index gltfNode);

    GltfDocument& document_;
    Scene& scene_;
    const std::vector<Index>& nodeOf_;
    std::set<std::string> names_;
    std::set<std::pair<AnimatedProperty, Index>> movedByClip_;  // of the current clip
    std::map<Index, Index> movingAt_, weightsAt_;               // by node
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
