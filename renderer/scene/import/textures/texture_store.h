// Pictures that materials ask for, decoded once per colour space on several threads.
#pragma once

#include "scene/import/base/scene_folder.h"
#include "scene/import/base/types.h"
#include "scene/scene.h"

#include <map>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

namespace clerestory {

// Where a picture's bytes are: a file of the scene's folder, or memory that outlives the store.
struct ImageSource {
    std::string name;  // for people, and the file's name when `embedded` is empty
    std::string key;   // tells pictures apart
    std::span<const unsigned char> embedded;
    std::string coverage = {};  // a file whose brightness becomes the picture's alpha; may be empty
};

class TextureStore {
public:
    TextureStore(const SceneFolder& folder, const ImportLimits& limits)
        : folder_(folder), limits_(limits) {}

    // `sampling.image` is ignored. The index is good for material slots until finish().
    Index texture(const ImageSource& source, ColorSpace colorSpace, const Texture& sampling);

    // Decodes everything into scene.images and scene.textures, in the order of asking. A picture
    // that is missing or broken is a warning, and the slots that wanted it become empty, so that
    // the material's factors stand alone.
    void finish(Scene& scene, const ProgressCallback& progress);

private:
    struct Request {
        ImageSource source;
        ColorSpace colorSpace;
    };
    const SceneFolder& folder_;
    ImportLimits limits_;
    std::vector<Request> requests_;
    std::map<std::pair<std::string, ColorSpace>, Index> requestOf_;
    std::vector<Texture> textures_;
};

}  // namespace clerestory
