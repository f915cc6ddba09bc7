// Materials of OBJ/MTL, COLLADA, FBX, 3DS, PLY and STL -> glTF materials.
#pragma once

#include "scene/import/textures/texture_store.h"

#include <string>

struct aiMaterial;
struct aiScene;

namespace clerestory {

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

}  // namespace clerestory
