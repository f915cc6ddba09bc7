// Animations of FBX and COLLADA -> clips on nodes; skins of the meshes that they move. Assimp has
// made straight lines of the files' curves, at their own keys or denser.
//
// Does not: read morph targets; a file that moves some gets a warning.
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

class AssimpMotion {
public:
    // nodeNamed: the scene's nodes, filled before readClips() is called. metresPerUnit: what the
    // root, the scene's first node, was scaled by. All must outlive this.
    AssimpMotion(const aiScene& file, Scene& scene, const std::map<std::string, Index>& nodeNamed,
                 double metresPerUnit)
        : file_(file), scene_(scene), nodeNamed_(nodeNamed), metresPerUnit_(metresPerUnit) {}

    // Appends the file's clips. Channels that are not sound are left out with a warning.
    void readClips();

    // Whether some clip moves a bone of the mesh.
    bool moves(const aiMesh& mesh) const;
    // Lets bones move the scene's mesh that was added last. sources: which of the file's vertices
    // each of its own was.
    void addDeformation(const aiMesh& from, const std::vector<std::uint32_t>& sources);

private:
    void readClip(const aiAnimation& animation, std::size_t number);
    // How many of the channel's three tracks were not sound.
    int addTracks(const aiNodeAnim& channel, double ticksPerSecond, double firstTick, Clip& clip);
    Index nodeOf(const aiString& name) const;
    Index movingNode(Index node, const Transform& rest);
    Index addSkin(const aiMesh& from);

    const aiScene& file_;
    Scene& scene_;
    const std::map<std::string, Index>& nodeNamed_;
    double metresPerUnit_;
    std::set<std::string> names_;
    std::set<std::pair<AnimatedProperty, Index>> movedByClip_;  // of the clip that is being read
    std::map<Index, Index> movingAt_;                           // by node
    std::vector<bool> nodeMoves_;
};

}  // namespace clerestory
