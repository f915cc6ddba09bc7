// The environment maps by name: built-in ones, files that the options name, and uploads, which load
// when they are first requested. Uploaded maps that nothing uses are evicted, the least recently
// used one first, when all of them exceed kUploadedMapBytes. Thread-safe.
#pragma once

#include "plan/request/frame_request.h"
#include "scene/environment.h"
#include "scene/import/import.h"
#include "server/queue/render_queue.h"
#include "server/scenes/upload_store.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
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

class EnvironmentLibrary {
public:
    // Loads the files, and adds their maps to the renderer. `uploads` may be null: not allowed.
    // Throws ImportError.
    EnvironmentLibrary(const std::vector<std::filesystem::path>& files, const ImportOptions& import,
                       std::shared_ptr<UploadStore> uploads, const ImportOptions& importUploads,
                       RenderQueue& queue);

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
    // result exists, which must not outlive the render queue. Throws RequestError 422 if an upload
    // cannot be loaded.
    std::shared_ptr<const EnvironmentMap> require(const std::string& name);
    // The uploads among the maps that the request names, loaded. Throws RequestError 422 with the
    // field that names the map.
    using Leases = std::vector<std::shared_ptr<const EnvironmentMap>>;
    Leases requireUploads(const FrameRequest& request);

    // Built-in ones first, then files, then uploads.
    std::vector<MapStatus> all() const;
    // Throws RequestError 404.
    MapStatus status(const std::string& name) const;
    // Frames in progress are finished with it. The file is left. Throws RequestError: no such map
    // (404), not an upload (403).
    void remove(const std::string& name);
    std::uint64_t uploadedBytes() const;  // of the loaded uploads

private:
    struct Loaded {
        std::shared_ptr<const EnvironmentMap> lease;
        std::uint64_t lastUsed = 0;
    };
    std::shared_ptr<const EnvironmentMap> upload(const std::string& name);
    std::shared_ptr<const EnvironmentMap> loadedUpload(const std::string& name);
    std::shared_ptr<const EnvironmentMap> load(const Upload& upload);
    void makeRoom(std::uint64_t bytes);

    RenderQueue& queue_;
    std::map<std::string, std::shared_ptr<const EnvironmentMap>> files_;
    const std::shared_ptr<UploadStore> uploads_;
    const ImportOptions importUploads_;

    std::mutex loading_;  // one import at a time; locked before mutex_
    mutable std::mutex mutex_;
    std::map<std::string, Loaded> loaded_;
    std::uint64_t uses_ = 0;
};

}  // namespace clerestory
