#include "server/scenes/cache_folder.h"

#include "renderer.h"
#include "scene/import/cache/scene_cache.h"
#include "server/base/log.h"
#include "server/base/process.h"

#include <cstdlib>
#include <functional>
#include <string>

namespace clerestory {
namespace {

// Logs that a file cannot be written. The default folder may be missing without harm.
std::function<void(const std::string&)> reportOf(const CacheOptions& options) {
    return [chosen = !options.folder.empty()](const std::string& words) {
        chosen ? logWarning({words}) : logDebug({words});
    };
}

}  // namespace

std::filesystem::path userCache() {
    const auto absolute = [](const char* name) -> std::filesystem::path {
        const char* value = std::getenv(name);
        const std::filesystem::path path = value ? value : "";
        return path.is_absolute() ? path : std::filesystem::path();
    };
    if (const auto xdg = absolute("XDG_CACHE_HOME"); !xdg.empty()) return xdg / "clerestory";
    const auto home = absolute("HOME");
    return home.empty() ? home : home / ".cache" / "clerestory";
}

std::filesystem::path cacheFolderOf(const CacheOptions& options) {
    if (options.folder.empty()) return userCache();
    return options.folder == "none" ? std::filesystem::path() : options.folder;
}

std::shared_ptr<SceneCache> sceneCacheOf(const CacheOptions& options) {
    const std::filesystem::path folder = cacheFolderOf(options);
    if (folder.empty()) return nullptr;
    return std::make_shared<SceneCache>(SceneCacheOptions{.folder = folder,
                                                          .maxBytes = options.mostBytes,
                                                          .version = buildId(),
                                                          .reportFailure = reportOf(options)});
}

void storeLight(LightOptions& light, const CacheOptions& options) {
    light.folder = cacheFolderOf(options);
    light.folderBytes = options.mostBytes;
    light.version = buildId();
    light.reportFailure = reportOf(options);
}

}  // namespace clerestory
