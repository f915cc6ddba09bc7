#include "scene/import/textures/environment_reader.h"

#include "scene/import/base/scene_folder.h"
#include "scene/import/base/types.h"
#include "scene/import/textures/cube_file.h"
#include "scene/import/textures/image_decoder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace clerestory {
namespace {

using Reason = ImportError::Reason;
using Bytes = std::span<const unsigned char>;

Bytes bytesOf(const std::string& file) {
    return {reinterpret_cast<const unsigned char*>(file.data()), file.size()};
}

// Finite, not negative, at most the largest half float.
glm::vec3 cleaned(const glm::vec3& texel) {
    constexpr float kLargestHalf = 65504.0f;
    glm::vec3 result(0.0f);
    for (int c = 0; c < 3; ++c) {
        result[c] = std::isnan(texel[c]) ? 0.0f : std::clamp(texel[c], 0.0f, kLargestHalf);
    }
    return result;
}

// Half the edge length; each texel is the mean of four.
RadianceCube halved(const RadianceCube& from) {
    RadianceCube to{.faceSize = from.faceSize / 2, .texels = {}};
    to.texels.reserve(from.texels.size() / 4);
    for (std::size_t y = 0; y < std::size_t{6} * from.faceSize; y += 2) {
        for (std::size_t x = 0; x < from.faceSize; x += 2) {
            const auto at = [&](std::size_t dx, std::size_t dy) {
                return from.texels[(y + dy) * from.faceSize + x + dx];
            };
            to.texels.push_back(0.25f * (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)));
        }
    }
    return to;
}

EnvironmentMap mapOf(RadianceCube cube) {
    for (glm::vec3& texel : cube.texels) texel = cleaned(texel);
    while (cube.faceSize > kMaxImportedFace) {
        if (cube.faceSize % 2 == 1) {
            throw ImportError(Reason::limit, "faces of " + std::to_string(cube.faceSize) +
                                                 " texels an edge cannot be halved");
        }
        cube = halved(cube);
    }
    EnvironmentMap map;
    map.faceSize = cube.faceSize;
    map.texels = std::move(cube.texels);
    return map;
}

// Two naming conventions for the faces +x, -x, +y, -y, +z and -z, OpenGL's order.
using FaceNames = std::array<const char*, 2>;
constexpr std::array<FaceNames, 6> kFaces{{{"px", "posx"},
                                           {"nx", "negx"},
                                           {"py", "posy"},
                                           {"ny", "negy"},
                                           {"pz", "posz"},
                                           {"nz", "negz"}}};

std::string faceFile(const SceneFolder& folder, const FaceNames& names) {
    for (const std::string name : names) {
        for (const char* extension : {".hdr", ".exr", ".png", ".jpg", ".jpeg"}) {
            if (folder.has(name + extension)) return name + extension;
        }
    }
    throw ImportError(Reason::notFound, std::string("the folder has no image named ") + names[0] +
                                            " or " + names[1] +
                                            " (.hdr, .exr, .png, .jpg or .jpeg)");
}

RadianceCube sixImages(const std::filesystem::path& path, const ImportLimits& limits) {
    const SceneFolder folder(path, limits.fileBytes);
    RadianceCube cube;
    for (const FaceNames& names : kFaces) {
        const std::string face = faceFile(folder, names);
        const RadianceImage image =
            decodedRadiance(bytesOf(folder.read(face)), limits.maxImagePixels / 6);
        if (cube.faceSize == 0) cube.faceSize = image.width;
        if (image.width != cube.faceSize || image.height != cube.faceSize) {
            throw ImportError(
                Reason::malformed,
                "the six images must be square and of equal size; " + face + " is not");
        }
        cube.texels.insert(cube.texels.end(), image.texels.begin(), image.texels.end());
    }
    return cube;
}

}  // namespace

EnvironmentMap readEnvironmentFile(const std::filesystem::path& fileOrFolder,
                                   const ImportLimits& limits) {
    std::error_code error;
    if (std::filesystem::is_directory(fileOrFolder, error)) {
        return mapOf(sixImages(fileOrFolder, limits));
    }
    const std::string extension = lowerExtension(fileOrFolder);
    constexpr std::array kExtensions{"hdr", "exr", "ktx", "ktx2", "dds"};
    if (std::find(kExtensions.begin(), kExtensions.end(), extension) == kExtensions.end()) {
        throw ImportError(
            Reason::unsupported,
            "an environment map is a .hdr, .exr, .ktx, .ktx2 or .dds file, or a folder "
            "of six images");
    }
    const SceneFolder folder(fileOrFolder.parent_path(), limits.fileBytes);
    const std::string file = folder.read(fileOrFolder.filename().string());
    if (extension != "hdr" && extension != "exr") {
        return mapOf(decodedCube(bytesOf(file), limits.maxImagePixels));
    }
    const RadianceImage image = decodedRadiance(bytesOf(file), limits.maxImagePixels);
    return environmentFromEquirectangular("", image.texels, image.width, image.height);
}

}  // namespace clerestory
