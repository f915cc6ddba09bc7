// Chooses the reader by the file's extension.
#include "scene/import/in_process.h"

#include "scene/import/assimp/scene.h"
#include "scene/import/base/archive.h"
#include "scene/import/base/cleaning.h"
#include "scene/import/base/sidecar.h"
#include "scene/import/formats.h"
#include "scene/import/gltf/scene.h"
#include "scene/import/textures/environment_reader.h"

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
    const bool sidecarApplied = applySidecar(scene, folder, name);
    if (dropUnknownProbes(scene) || sidecarApplied) finishScene(scene);
    scene.title = cleanText(std::filesystem::path(name).stem().string());
    return scene;
}

}  // namespace

Scene importSceneInProcess(const std::filesystem::path& file, const ImportLimits& limits,
                           const ProgressCallback& progress,
                           const DependencyCallback& dependencies) {
    const std::string extension = lowerExtension(file);
    const auto& known = importableExtensions();
    if (std::find(known.begin(), known.end(), extension) == known.end()) {
        throw ImportError(
            ImportError::Reason::unsupported,
            "files with the extension '." + cleanText(extension) + "' are not supported");
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
    if (dependencies) {
        for (const FileDependency& each : folder.dependencies()) dependencies(each);
    }
    return scene;
}

EnvironmentMap loadEnvironmentInProcess(const std::filesystem::path& fileOrFolder,
                                        const ImportLimits& limits) {
    return readEnvironmentFile(fileOrFolder, limits);
}

}  // namespace clerestory
