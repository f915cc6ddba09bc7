// The import as the server calls it: cache, child process, check of the result.
#include "scene/import/import.h"

#include "scene/import/base/clean_text.h"
#include "scene/import/base/imported_scene.h"
#include "scene/import/cache/blob.h"
#include "scene/import/cache/scene_cache.h"
#include "scene/import/sandbox/process.h"

#include <optional>
#include <utility>

namespace clerestory {
namespace {

using Reason = ImportError::Reason;

Scene checkedScene(std::span<const std::byte> blob) {
    try {
        Scene scene = readScene(blob);
        if (const auto problems = sceneProblems(scene); !problems.empty()) {
            throw ImportError(Reason::crashed,
                              "the import returned an invalid scene: " + problems.front());
        }
        return scene;
    } catch (const BlobError&) {
        throw ImportError(Reason::crashed, "the import returned a damaged scene");
    } catch (const std::bad_alloc&) {
        throw ImportError(Reason::memory, "not enough memory for the scene");
    }
}

}  // namespace

SceneSource sceneSource(const std::string& text) {
    std::error_code error;
    const std::size_t colon = text.rfind(':');
    const bool whole = colon == std::string::npos || std::filesystem::exists(text, error) ||
                       !std::filesystem::is_regular_file(text.substr(0, colon), error);
    if (whole) return {text, ""};
    return {text.substr(0, colon), text.substr(colon + 1)};
}

Scene importScene(const std::filesystem::path& file, const ImportOptions& options,
                  const ProgressCallback& progress) {
    const auto key =
        options.cache ? options.cache->keyOf(file, options.limits, options.scene) : std::nullopt;
    if (key) {
        if (auto cached = options.cache->find(*key)) return *std::move(cached);
    }
    const ChildResult result =
        runImportChild(file, "scene", options.scene, options.importer, options.limits, progress);
    Scene scene = checkedScene(result.bytes);
    if (key) options.cache->store(*key, result.dependencies, result.bytes, result.owner);
    if (progress) {
        progress({"transferring", 1.0});
    }
    return scene;
}

EnvironmentMap loadEnvironment(const std::filesystem::path& fileOrFolder,
                               const ImportOptions& options) {
    std::filesystem::path path = fileOrFolder;
    if (!path.has_filename()) path = path.parent_path();  // "folder/" becomes "folder"
    try {
        const ChildResult result =
            runImportChild(path, "environment", "", options.importer, options.limits, {});
        EnvironmentMap map = readEnvironment(result.bytes);
        std::error_code error;
        const bool folder = std::filesystem::is_directory(path, error);
        map.name = map.title = cleanText((folder ? path.filename() : path.stem()).string());
        return map;
    } catch (const BlobError&) {
        throw ImportError(Reason::crashed, "the import returned a damaged environment map");
    } catch (const std::bad_alloc&) {
        throw ImportError(Reason::memory, "not enough memory for the environment map");
    }
}

}  // namespace clerestory
