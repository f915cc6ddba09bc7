// glTF 2.0 materials with the KHR_materials_* extensions, read from the JSON.
#pragma once

#include "scene/import/gltf/document.h"
#include "scene/import/textures/texture_store.h"

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
    void readExtensions(const Json& json, Material& m);
    TextureSlot slot(const Json& parent, const char* key, ColorSpace colorSpace);
    Index texture(Index gltfTexture, ColorSpace colorSpace);
    ImageSource imageSource(Index gltfImage);

    GltfDocument& document_;
    TextureStore& textures_;
    Scene& scene_;
};

}  // namespace clerestory
