// Collects the textures of all materials and decodes each image once per colour space, on several
// threads.
#pragma once

#include "scene/import/base/scene_folder.h"
#include "scene/import/base/types.h"
#include "scene/import/textures/specular_glossiness.h"
#include "scene/scene.h"

#include <map>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

namespace clerestory {

// The bytes of an image: a file in the scene's folder, or memory that outlives the store.
struct ImageSource {
    std::string name;  // for messages; the file's name if `embedded` is empty
    std::string key;   // identifies the image
    std::span<const unsigned char> embedded;
    std::string coverage = {};  // a file whose brightness is the image's alpha; may be empty
};

// An image that is computed from the images of a material with specular and glossiness.
struct ConvertedSource {
    std::optional<ImageSource> diffuse, specular;  // white if it is missing or damaged
    SpecularGlossinessFactors factors;
    ConvertedTo result = ConvertedTo::baseColor;
};

class TextureStore {
public:
    TextureStore(const SceneFolder& folder, const ImportLimits& limits)
        : folder_(folder), limits_(limits) {}

    // `sampling.image` is ignored. The index is valid for material slots; finish() replaces it.
    Index texture(const ImageSource& source, ColorSpace colorSpace, const Texture& sampling);
    // The same of a converted image; each call adds one.
    Index texture(const ConvertedSource& source, const Texture& sampling);

    // Decodes all images into scene.images and scene.textures, in the order of the requests. A
    // missing or damaged image adds a warning, and its slots become empty, so that only the
    // material's factors apply; of a converted one its slots keep what the other image gives.
    void finish(Scene& scene, const ProgressCallback& progress);

private:
    struct Request {
        ImageSource source;  // of a converted image: the name only
        ColorSpace colorSpace;
        std::optional<ConvertedSource> converted = {};
    };
    Index textureOf(Index request, const Texture& sampling);
    const SceneFolder& folder_;
    ImportLimits limits_;
    std::vector<Request> requests_;
    std::map<std::pair<std::string, ColorSpace>, Index> requestOf_;
    std::vector<Texture> textures_;
};

}  // namespace clerestory
