// Environment maps from the operator's own files.
#include "scene/import/image_decoder.h"
#include "scene/import/import.h"
#include "scene/import/scene_cleaning.h"
#include "scene/import/scene_folder.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace clerestory {
namespace {

using Reason = ImportError::Reason;

RadianceImage readRadiance(const SceneFolder& folder, const std::string& name) {
    const std::string file = folder.read(name);
    return decodedRadiance({reinterpret_cast<const unsigned char*>(file.data()), file.size()},
                           ImportLimits{}.maxImagePixels);
}

EnvironmentMap fromSixImages(const std::filesystem::path& path) {
    constexpr std::array kFaces{"px", "nx", "py", "ny", "pz", "nz"};  // OpenGL's order
    constexpr std::array kKinds{".hdr", ".png", ".jpg", ".jpeg"};
    const SceneFolder folder(path, ImportLimits{}.fileBytes);
    EnvironmentMap map;
    map.name = cleanText(path.filename().string());
    for (const std::string face : kFaces) {
        const auto kind = std::find_if(kKinds.begin(), kKinds.end(), [&](const char* extension) {
            return folder.has(face + extension);
        });
        if (kind == kKinds.end()) {
            throw ImportError(Reason::notFound, "the folder has no picture named " + face);
        }
        const RadianceImage image = readRadiance(folder, face + *kind);
        if (map.faceSize == 0) {
            map.faceSize = image.width;
        }
        if (image.width != map.faceSize || image.height != map.faceSize) {
            throw ImportError(
                Reason::malformed,
                "the six pictures must be square and of one size; " + face + " is not");
        }
        for (const glm::vec3& texel : image.texels) {
            constexpr float kLargestHalf = 65504.0f;
            glm::vec3 kept(0.0f);
            for (int c = 0; c < 3; ++c) {
                kept[c] = std::isnan(texel[c]) ? 0.0f : std::clamp(texel[c], 0.0f, kLargestHalf);
            }
            map.texels.push_back(kept);
        }
    }
    updateContentHash(map);
    return map;
}

}  // namespace

EnvironmentMap loadEnvironment(const std::filesystem::path& fileOrFolder) {
    std::filesystem::path path = fileOrFolder;
    if (!path.has_filename()) {
        path = path.parent_path();  // "folder/" is "folder"
    }
    std::error_code error;
    EnvironmentMap map;
    if (std::filesystem::is_directory(path, error)) {
        map = fromSixImages(path);
    } else {
        if (path.extension() != ".hdr") {
            throw ImportError(Reason::unsupported,
                              "an environment map is an .hdr file or a folder of six pictures");
        }
        const SceneFolder folder(path.parent_path(), ImportLimits{}.fileBytes);
        const RadianceImage image = readRadiance(folder, path.filename().string());
        map = environmentFromEquirectangular(cleanText(path.stem().string()), image.texels,
                                             image.width, image.height);
    }
    map.title = map.name;
    return map;
}

}  // namespace clerestory
