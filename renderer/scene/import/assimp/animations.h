// Animations of FBX and COLLADA -> clips of node transforms, and skins of the meshes that they
// move. Assimp has sampled the files' curves to linear keys.
//
// Does not: read morph targets; a file that animates them gets a warning.
#pragma once

#include "scene/scene.h"

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

struct aiAnimation;
struct aiMesh;
struct aiNodeAnim;
struct aiScene;
struct aiString;

namespace clerestory {

class AssimpAnimations {
public:
    // nodeNamed: the scene's nodes by name, filled before readClips() is called. metresPerUnit: the
    // scale of the root, which is the scene's first node. All must outlive the object.
    AssimpAnimations(const aiScene& file, Scene& scene,
                     const std::map<std::string, Index>& nodeNamed, double metresPerUnit)
        : file_(file), scene_(scene), nodeNamed_(nodeNamed), metresPerUnit_(metresPerUnit) {}

    // Appends the file's clips. Invalid channels are skipped with a warning.
    void readClips();

    // Whether a clip moves a bone of the mesh.
    bool moves(const aiMesh& mesh) const;
    // Adds a deformation to the scene's last mesh. sources: the file's vertex index of each vertex.
    void addDeformation(const aiMesh& from, const std::vector<std::uint32_t>& sources);

private:
    void readClip(const aiAnimation& animation, std::size_t number);
    // Returns how many of the channel's three tracks were invalid.
    int addTracks(const aiNodeAnim& channel, double ticksPerSecond, double firstTick, Clip& clip);
    Index nodeOf(const aiString& name) const;
    Index movingNode(Index node, const Transform& rest);
    Index addSkin(const aiMesh& from);

    const aiScene& file_;
    Scene& scene_;
    const std::map<std::string, Index>& nodeNamed_;
    double metresPerUnit_;
    std::set<std::string> names_;
    std::set<std::pair<AnimatedProperty, Index>> movedByClip_;  // of the current clip
    std::map<Index, Index> movingAt_;                           // by node
    std::vector<bool> nodeMoves_;
};

}  // namespace clerestory
