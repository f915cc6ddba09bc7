#include "server/scenes/cache_folder.h"

#include "scene/import/cache/scene_cache.h"
#include "server/base/log.h"
#include "server/base/process.h"

#include <cstdlib>

namespace clerestory {
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
    const bool chosen = !options.folder.empty();
    const std::filesystem::path folder = cacheFolderOf(options);
    if (folder.empty()) return nullptr;
    return std::make_shared<SceneCache>(
        SceneCacheOptions{.folder = folder,
                          .maxBytes = options.mostBytes,
                          .version = buildId(),
                          .reportFailure = [chosen](const std::string& words) {
                              // The default folder may be missing without harm.
                              chosen ? logWarning({words}) : logDebug({words});
                          }});
}

}  // namespace clerestory
