// Readers of the parts of a file that Assimp has read: materials of OBJ/MTL, COLLADA, FBX, 3DS, PLY
// and STL as glTF materials; animations of FBX and COLLADA as clips of node transforms, and skins
// of the meshes that they move. Assimp has sampled the files' curves to linear keys.
//
// Does not: read morph targets; a file that animates them gets a warning.
#pragma once

#include "scene/import/textures/texture_store.h"
#include "scene/scene.h"

#include <assimp/matrix4x4.h>
#include <glm/glm.hpp>

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

struct aiMaterial;
struct aiScene;
struct aiAnimation;
struct aiMesh;
struct aiNodeAnim;
struct aiString;

namespace clerestory {

inline glm::dmat4 matrixOf(const aiMatrix4x4& m) {
    return {m.a1, m.b1, m.c1, m.d1, m.a2, m.b2, m.c2, m.d2,
            m.a3, m.b3, m.c3, m.d3, m.a4, m.b4, m.c4, m.d4};
}

// The perceptual roughness for a specular exponent of Blinn or Phong: GGX's alpha is
// sqrt(2 / (exponent + 2)) (Walter et al. 2007), and roughness is its square root.
float roughnessFromExponent(float exponent);

class AssimpMaterials {
public:
    // `extension` is the file's, lower case. All arguments must outlive the object.
    AssimpMaterials(const aiScene& file, const std::string& extension, const SceneFolder& folder,
                    TextureStore& textures, Scene& scene)
        : file_(file),
          isObj_(extension == "obj"),
          folder_(folder),
          textures_(textures),
          scene_(scene) {}

    void read();  // one Material for each of the file's, in the same order

    // Call after the meshes were added. MTL has no thickness: glass with an index of refraction
    // gets the smallest extent of its largest mesh, which is 0 for a flat sheet.
    void setGlassThickness();

private:
    Material material(const aiMaterial& from);
    void readSurface(const aiMaterial& from, Material& m);
    void readReflection(const aiMaterial& from, Material& m);
    void readTransparency(const aiMaterial& from, Material& m);
    void readTextures(const aiMaterial& from, Material& m);
    TextureSlot slot(const aiMaterial& from, int kind, ColorSpace colorSpace,
                     const std::string& coverage = {});
    ImageSource imageSource(std::string path);

    const aiScene& file_;
    bool isObj_;
    const SceneFolder& folder_;
    TextureStore& textures_;
    Scene& scene_;
};

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
