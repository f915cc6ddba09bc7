// The environment maps by name: built-in ones, files that the options name, and uploads, which load
// when they are first requested, one after another on a background thread. Uploaded maps that
// nothing uses are evicted, the least recently used one first, when all of them exceed
// kUploadedMapBytes. Thread-safe.
#pragma once

#include "plan/request/frame_request.h"
#include "scene/environment.h"
#include "scene/import/import.h"
#include "server/base/problem.h"
#include "server/base/process.h"
#include "server/queue/render_queue.h"
#include "server/scenes/upload_store.h"

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace clerestory {

// Two maps of the largest size.
inline constexpr std::uint64_t kUploadedMapBytes = 160u << 20;

enum class MapSource { builtIn, file, uploaded };
std::string_view nameOf(MapSource source);

// For GET /v1/environments.
struct MapStatus {
    std::string name, title;
    MapSource source = MapSource::builtIn;
};

// A map that a request names: all names, known or not.
struct NamedMap {
    std::string name, pointer;  // JSON Pointer of the field
};
std::vector<NamedMap> mapsNamedBy(const FrameRequest& request);

// How long a call waits for uploads that load.
using MapPatience = std::chrono::duration<double>;
inline constexpr MapPatience kMapPatience{5.0};
inline constexpr MapPatience kUnlimitedMapPatience = MapPatience::max();
// Calls with limited patience that may wait at once: each occupies a thread that other requests
// need. Further ones do not wait.
inline constexpr std::size_t kMaxWaitingForMaps = 4;

class EnvironmentLibrary {
public:
    // Loads the files, and adds their maps to the renderer. `uploads` may be null: not allowed.
    // Throws ImportError.
    EnvironmentLibrary(const std::vector<std::filesystem::path>& files, const ImportOptions& import,
                       std::shared_ptr<UploadStore> uploads, const ImportOptions& importUploads,
                       RenderQueue& queue);
    ~EnvironmentLibrary();  // an import in progress is finished
    EnvironmentLibrary(const EnvironmentLibrary&) = delete;
    EnvironmentLibrary& operator=(const EnvironmentLibrary&) = delete;

    // A built-in map, which is made each time, or one of a file; null if there is none with this
    // name.
    std::shared_ptr<const EnvironmentMap> find(const std::string& name) const;
    bool has(const std::string& name) const;
    // Those of files.
    std::vector<std::shared_ptr<const EnvironmentMap>> fromFiles() const;
    // Those that find() knows; built-in ones first.
    std::vector<std::string> names() const;
    // The content hash of a map from a file; 0 for any other. The name of an upload is a hash.
    std::uint64_t hash(const std::string& name) const;

    // As find(), and uploads. An upload stays loaded, here and in the renderer, as long as the
    // result exists, which must not outlive the render queue. Throws RequestError: an upload is
    // still loading (409), cannot be loaded (422).
    std::shared_ptr<const EnvironmentMap> require(const std::string& name);
    // The uploads among the maps that the request names, loaded. patience: for all of them, at most
    // kMapPatience unless it is kUnlimitedMapPatience, which is for the server's own threads.
    // Throws as require(), 422 with the field that names the map.
    using Leases = std::vector<std::shared_ptr<const EnvironmentMap>>;
    Leases requireUploads(const FrameRequest& request, MapPatience patience = kMapPatience);

    // Built-in ones first, then files, then uploads.
    std::vector<MapStatus> all() const;
    // Throws RequestError 404.
    MapStatus status(const std::string& name) const;
    // Frames in progress are finished with it. The file is left. Throws RequestError: no such map
    // (404), not an upload (403).
    void remove(const std::string& name);
    std::uint64_t uploadedBytes() const;  // of the loaded uploads
    std::size_t waitingCalls() const;     // with limited patience, for an upload that loads

private:
    struct Loaded {
        std::shared_ptr<const EnvironmentMap> lease;
        std::uint64_t lastUsed = 0;
    };
    struct Outcome {
        std::shared_ptr<const EnvironmentMap> lease;
        std::optional<Problem> failure;  // then there is no lease
    };
    // Shared by the loader and the calls that wait for it.
    struct Import {
        const Upload upload;
        std::optional<Outcome> outcome;  // none: not finished
    };
    using Until = std::optional<Clock::time_point>;  // none: without limit
    std::shared_ptr<const EnvironmentMap> upload(const std::string& name, Until until);
    std::shared_ptr<const EnvironmentMap> loadedUpload(const std::string& name);
    std::shared_ptr<Import> importOf(const Upload& upload);
    void await(const Import& import, Until until, std::unique_lock<std::mutex>& lock);
    void loadAll();
    Outcome load(const Upload& upload);
    void makeRoom(std::uint64_t bytes);
    void forget(const std::string& name);

    RenderQueue& queue_;
    std::map<std::string, std::shared_ptr<const EnvironmentMap>> files_;
    const std::shared_ptr<UploadStore> uploads_;
    const ImportOptions importUploads_;

    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::map<std::string, Loaded> loaded_;
    // By name: unfinished ones, and failed ones until a call has reported the failure.
    std::map<std::string, std::shared_ptr<Import>> imports_;
    std::deque<std::shared_ptr<Import>> toLoad_;
    std::size_t waitingCalls_ = 0;
    std::uint64_t uses_ = 0;
    bool ending_ = false;
    std::thread loader_;  // started by the first import
};

}  // namespace clerestory
