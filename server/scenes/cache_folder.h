// Where imported scenes are cached from one start to the next.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

namespace clerestory {

class SceneCache;
struct LightOptions;

struct CacheOptions {
    std::filesystem::path folder;  // empty: the user's cache folder; "none": no cache
    std::uint64_t mostBytes = 4ull << 30;
};

// The user's cache folder by the XDG Base Directory Specification; empty if there is none.
std::filesystem::path userCache();

// The folder that the options choose; empty for no cache.
std::filesystem::path cacheFolderOf(const CacheOptions& options);

// Null for no cache.
std::shared_ptr<SceneCache> sceneCacheOf(const CacheOptions& options);
// The light between their surfaces is stored in the same folder.
void storeLight(LightOptions& light, const CacheOptions& options);

}  // namespace clerestory
