// The import in this process: chooses the reader by the file's extension.
#include "scene/import/import.h"

#include "scene/import/assimp_scene.h"
#include "scene/import/gltf_scene.h"
#include "scene/import/scene_archive.h"
#include "scene/import/scene_cleaning.h"
#include "scene/import/side_file.h"

#include <algorithm>

namespace clerestory {
namespace {

std::string lowerExtension(const std::filesystem::path& file) {
    std::string extension = file.extension().string();
    extension.erase(0, extension.empty() ? 0 : 1);
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
    return extension;
}

Scene sceneIn(const SceneFolder& folder, const std::string& name, const ImportLimits& limits,
              const ProgressCallback& progress) {
    const std::string extension = lowerExtension(name);
    const bool isGltf = extension == "gltf" || extension == "glb";
    if (!isGltf && !folder.has(name)) {
        throw ImportError(ImportError::Reason::notFound,
                          "'" + cleanText(name) + "' is not a readable file");
    }
    Scene scene = isGltf ? gltfScene(folder.read(name), folder, limits, progress)
                         : assimpScene(name, extension, folder, limits, progress);
    finishScene(scene);
    const bool sideFileApplied = applySideFile(scene, folder, name);
    if (dropUnknownProbes(scene) || sideFileApplied) finishScene(scene);
    scene.title = cleanText(std::filesystem::path(name).stem().string());
    return scene;
}

}  // namespace

Scene importSceneHere(const std::filesystem::path& file, const ImportLimits& limits,
                      const ProgressCallback& progress, const ReadingCallback& readings) {
    const std::string extension = lowerExtension(file);
    const auto& known = importableExtensions();
    if (std::find(known.begin(), known.end(), extension) == known.end()) {
        throw ImportError(ImportError::Reason::unsupported,
                          "files of the kind '." + cleanText(extension) + "' cannot be read");
    }
    if (progress) {
        progress({"reading", 0.0});
    }
    const SceneFolder folder(file.parent_path(), limits.fileBytes, limits.maxFiles);
    const std::string name = file.filename().string();
    Scene scene;
    if (isArchive(extension)) {
        UnpackedScene unpacked = unpackedScene(folder.read(name), limits);
        scene = sceneIn(SceneFolder(std::move(unpacked.files)), unpacked.name, limits, progress);
    } else {
        scene = sceneIn(folder, name, limits, progress);
    }
    if (readings) {
        for (const FileReading& reading : folder.readings()) readings(reading);
    }
    return scene;
}

}  // namespace clerestory
