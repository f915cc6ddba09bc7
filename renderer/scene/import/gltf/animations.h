// glTF 2.0 animations -> clips; what they move.
#pragma once

#include "scene/import/gltf/document.h"
#include "scene/scene.h"

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace clerestory {

class GltfMotion {
public:
    // nodeOf: the scene's node of each glTF node, kNone for those that are not in the scene. All
    // must outlive this.
    GltfMotion(GltfDocument& document, Scene& scene, const std::vector<Index>& nodeOf)
        : document_(document), scene_(scene), nodeOf_(nodeOf) {}

    // Appends the file's clips. A track that is not sound is left out with a warning.
    void readClips();

    // The place in Scene::morphWeights of what clips do to the mesh at a glTF node; or kNone.
    Index weightsOf(Index gltfNode) const;
    // Whether some clip moves a joint of the skin.
    bool moves(const Json& skin) const;
    // Appended to Scene::skins.
    Index addSkin(const Json& skin);

private:
    void readClip(const Json& animation, std::size_t number);
    // Whether it was added.
    bool addTrack(const Json& animation, const Json& json, Clip& clip);
    bool setTarget(const Json& target, Track& track);
    Index movingNode(Index gltfNode);
    Index morphWeights(Index gltfNode);

    GltfDocument& document_;
    Scene& scene_;
    const std::vector<Index>& nodeOf_;
    std::set<std::string> names_;
    std::set<std::pair<AnimatedProperty, Index>> movedByClip_;  // of the clip that is being read
    std::map<Index, Index> movingAt_, weightsAt_;               // by node
    std::vector<bool> nodeMoves_;
    Index stillNode_ = kNone;    // stands for joints that are not in the scene
    std::uint64_t numbers_ = 0;  // of all channels
};

// A node's place, as its parts or as a matrix.
Transform transformOf(const Json& node);

// The joints of a skin as nodes of the scene, kNone for those that are not in it, and their inverse
// bind matrices. Throws ImportError for a skin without joints.
struct GltfSkin {
    std::vector<Index> joints;
    std::vector<glm::dmat4> jointFromMesh;
};
GltfSkin gltfSkin(GltfDocument& document, const Json& skin, const std::vector<Index>& nodeOf);

// A list of indices of a glTF object.
std::vector<Index> indexList(const Json& parent, const char* key);

}  // namespace clerestory
