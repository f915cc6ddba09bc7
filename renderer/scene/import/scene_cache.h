// Imported scenes on the disk, so that a second start need not import them again. A scene is known
// by what it came from: the scene file's content and name, what was found of every other file that
// the import asked for, the limits, and the program that imported it.
//
// Whatever is damaged, cut short or out of date is as good as not there. Any number of processes
// may share a folder. Thread-safe.
#pragma once

#include "scene/import/file_reading.h"
#include "scene/import/import.h"

#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
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
    ~SceneCache();  // when everything is kept
    SceneCache(const SceneCache&) = delete;
    SceneCache& operator=(const SceneCache&) = delete;

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
    // `blob` is of writeScene(), and lies in what `owner` owns. Returns at once; what cannot be
    // kept is not kept. Scenes that were used longest ago give way.
    void keep(const Place& place, const std::vector<FileReading>& readings,
              std::span<const std::byte> blob, std::shared_ptr<const void> owner);
    void finish();  // waits until everything that was given is kept

private:
    struct Kept {
        std::filesystem::path file;
        std::string head;
        std::span<const std::byte> blob;
        std::shared_ptr<const void> owner;
    };
    void write();
    void write(const Kept& kept);
    std::filesystem::path fileOf(const Place& place) const;
    bool wrote(const Kept& kept) const;

    const SceneCacheOptions options_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<Kept> toWrite_;
    bool writing_ = false, ending_ = false, complained_ = false;
    std::thread writer_;  // since the first keep()
};

}  // namespace clerestory
