// Imported scenes on the disk, so that a second start need not import them again. A scene is known
// by what it came from: the scene file's content and name, what was found of every other file that
// the import asked for, the limits, and the program that imported it.
//
// Whatever is damaged, cut short or out of date is as good as not there. Any number of processes
// may share a folder. Thread-safe.
#pragma once

#include "scene/import/file_reading.h"
#include "scene/import/import.h"

#include <mutex>
#include <optional>
#include <span>
#include <vector>

namespace clerestory {

struct SceneCacheOptions {
    std::filesystem::path folder;  // made when first needed, for its owner alone
    std::uint64_t mostBytes = 4ull << 30;
    std::string version;  // of the program: another one has other scenes
    // Told once that scenes cannot be kept, in a line for people.
    std::function<void(const std::string&)> complain;
};

class SceneCache {
public:
    explicit SceneCache(SceneCacheOptions options) : options_(std::move(options)) {}

    // Where a scene would lie.
    struct Place {
        std::filesystem::path scene;  // the scene file
        ImportLimits limits;
        std::string key;    // of the scene file and all that is not in a folder
        FileReading whole;  // of the scene file
    };
    // Nothing when there is no such file that could be imported.
    std::optional<Place> placeOf(const std::filesystem::path& scene,
                                 const ImportLimits& limits) const;

    std::optional<Scene> find(const Place& place);
    // `blob` is of writeScene(). Those used longest ago give way. Never throws but std::bad_alloc:
    // what cannot be kept is not kept.
    void keep(const Place& place, const std::vector<FileReading>& readings,
              std::span<const std::byte> blob);

private:
    std::filesystem::path fileOf(const Place& place) const;
    bool write(const std::filesystem::path& file, std::span<const std::byte> head,
               std::span<const std::byte> blob) const;
    void sweep() const;

    const SceneCacheOptions options_;
    std::mutex mutex_;
    bool complained_ = false;
};

}  // namespace clerestory
