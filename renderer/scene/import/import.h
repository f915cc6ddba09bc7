// Files -> Scene, EnvironmentMap.
//
// The file is read in a child process (the libraries underneath crash, hang and exhaust memory on
// small hostile files), which returns one flat blob; the blob is checked before it is used. Nothing
// outside the scene file's folder is opened.
//
// Does not: know file formats (import/gltf, import/assimp, import/textures), draw, cache in memory.
#pragma once

#include "scene/environment.h"
#include "scene/import/base/types.h"
#include "scene/scene.h"

#include <filesystem>
#include <memory>

namespace clerestory {

class SceneCache;

struct ImportOptions {
    std::filesystem::path importer;  // the clerestory program; empty: /proc/self/exe
    ImportLimits limits;
    // Of a file with several: the name or the number of one, from 0. Empty: the file's default
    // scene.
    std::string scene;
    std::shared_ptr<SceneCache> cache;  // of scenes that were imported before; null: none
};

// A scene as people write it: a file, or a file, a colon and ImportOptions::scene.
struct SceneSource {
    std::filesystem::path file;  // may not exist
    std::string scene;
};
SceneSource sceneSource(const std::string& text);

// Returns the cached scene if the cache holds one for the same files. Throws ImportError.
Scene importScene(const std::filesystem::path& file, const ImportOptions& options = {},
                  const ProgressCallback& progress = {});

// An environment map: .hdr or .exr (equirectangular), a cube map as .ktx, .ktx2 or .dds, or a
// folder with px nx py ny pz nz (.hdr .exr .png .jpg). Faces larger than kMaxImportedFace are
// halved. Throws ImportError.
EnvironmentMap loadEnvironment(const std::filesystem::path& fileOrFolder,
                               const ImportOptions& options = {});

}  // namespace clerestory
