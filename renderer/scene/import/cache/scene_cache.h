// Imported scenes on disk, so that a restart does not import them again.
//
// An entry is identified by the scene file's content and name, which of its scenes it is, the state
// of every other file that the import looked for, the limits, and the version of the program.
// Damaged, truncated and outdated entries are ignored. Several processes may share a folder
// (scene/cache_file.h). Thread-safe.
#pragma once

#include "scene/cache_file.h"
#include "scene/import/base/scene_folder.h"
#include "scene/import/base/types.h"
#include "scene/scene.h"

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <vector>

namespace clerestory {

struct SceneCacheOptions {
    std::filesystem::path folder;  // created when first needed, accessible to its owner alone
    std::uint64_t maxBytes = 4ull << 30;
    std::string version;  // of the program; entries of other versions are not used
    // Called with one line for the log when the first of several writes fails.
    std::function<void(const std::string&)> reportFailure;
};

class SceneCache {
public:
    explicit SceneCache(SceneCacheOptions options) : options_(std::move(options)) {}
    ~SceneCache();  // writes all pending entries
    SceneCache(const SceneCache&) = delete;
    SceneCache& operator=(const SceneCache&) = delete;

    struct Key {
        std::filesystem::path scene;  // the scene file
        ImportLimits limits;
        std::string hash;        // of everything but the other files of the folder
        FileDependency content;  // the scene file's
    };
    // Nothing if the file cannot be read.
    std::optional<Key> keyOf(const std::filesystem::path& scene, const ImportLimits& limits,
                             const std::string& sceneOfFile = {}) const;

    std::optional<Scene> find(const Key& key);
    // Queues the entry and returns at once. `blob` is the output of writeScene(), in memory that
    // `owner` owns. The least recently used entries are removed to make room. An entry that cannot
    // be written is dropped.
    void store(const Key& key, const std::vector<FileDependency>& dependencies,
               std::span<const std::byte> blob, std::shared_ptr<const void> owner);
    void flush();  // waits until all queued entries are written

private:
    struct Entry {
        std::filesystem::path file;
        std::string head;
        std::span<const std::byte> blob;
        std::shared_ptr<const void> owner;
    };
    void runWriter();
    void write(const Entry& entry);
    std::filesystem::path fileOf(const Key& key) const;

    const SceneCacheOptions options_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<Entry> queue_;
    bool writing_ = false, ending_ = false, failureReported_ = false;
    std::thread writer_;  // started by the first store()
};

}  // namespace clerestory
