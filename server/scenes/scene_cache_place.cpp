#include "server/scenes/scene_cache_place.h"

#include "scene/import/cache/scene_cache.h"
#include "server/base/build_id.h"
#include "server/base/log.h"

#include <cstdlib>

namespace clerestory {
namespace {

// Empty where nothing is kept.
std::filesystem::path folderOf(const CacheOptions& options) {
    if (options.folder.empty()) return userCache();
    return options.folder == "none" ? std::filesystem::path() : options.folder;
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

std::shared_ptr<CurveStore> curveStoreOf(const CacheOptions& options) {
    const std::filesystem::path folder = folderOf(options);
    return folder.empty() ? nullptr : std::make_shared<CurveStore>(folder);
}

std::shared_ptr<SceneCache> sceneCacheOf(const CacheOptions& options) {
    const bool asked = !options.folder.empty();
    const std::filesystem::path folder = folderOf(options);
    if (folder.empty()) return nullptr;
    return std::make_shared<SceneCache>(
        SceneCacheOptions{.folder = folder,
                          .maxBytes = options.mostBytes,
                          .version = buildId(),
                          .reportFailure = [asked](const std::string& words) {
                              // Nobody asked for the usual place, so nobody misses it.
                              asked ? logWarning({words}) : logDebug({words});
                          }});
}

}  // namespace clerestory
