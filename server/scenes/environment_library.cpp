#include "server/scenes/environment_library.h"

#include "scene/spelling.h"
#include "server/base/log.h"
#include "server/base/problem.h"

#include <algorithm>
#include <optional>

namespace clerestory {
namespace {

std::uint64_t bytesOf(const EnvironmentMap& map) {
    return map.texels.size() * sizeof(map.texels[0]);
}

}  // namespace

std::string_view nameOf(MapSource source) {
    constexpr std::string_view kNames[] = {"builtIn", "file", "uploaded"};
    return kNames[static_cast<std::size_t>(source)];
}

std::vector<NamedMap> mapsNamedBy(const FrameRequest& request) {
    std::vector<NamedMap> named;
    if (request.environment.map) named.push_back({*request.environment.map, "/environment/map"});
    for (std::size_t i = 0; i < request.overrides.size(); ++i) {
        if (const auto& map = request.overrides[i].environmentMap) {
            named.push_back({*map, "/overrides/" + std::to_string(i) + "/environmentMap"});
        }
    }
    return named;
}

EnvironmentLibrary::EnvironmentLibrary(const std::vector<std::filesystem::path>& files,
                                       const ImportOptions& import,
                                       std::shared_ptr<UploadStore> uploads,
                                       const ImportOptions& importUploads, RenderQueue& queue)
    : queue_(queue), uploads_(std::move(uploads)), importUploads_(importUploads) {
    for (const auto& file : files) {
        auto map = std::make_shared<const EnvironmentMap>(loadEnvironment(file, import));
        files_[map->name] = map;
        queue_.post([map](Renderer& renderer) { renderer.addEnvironment(map); });
    }
}

std::shared_ptr<const EnvironmentMap> EnvironmentLibrary::find(const std::string& name) const {
    const auto found = files_.find(name);
    if (found != files_.end()) return found->second;
    auto builtin = builtinEnvironment(name);
    return builtin ? std::make_shared<const EnvironmentMap>(*std::move(builtin)) : nullptr;
}

bool EnvironmentLibrary::has(const std::string& name) const {
    const std::vector<std::string> known = names();
    return std::find(known.begin(), known.end(), name) != known.end();
}

std::vector<std::shared_ptr<const EnvironmentMap>> EnvironmentLibrary::fromFiles() const {
    std::vector<std::shared_ptr<const EnvironmentMap>> maps;
    for (const auto& [name, map] : files_) maps.push_back(map);
    return maps;
}

std::vector<std::string> EnvironmentLibrary::names() const {
    std::vector<std::string> names = builtinEnvironmentNames();
    for (const auto& [name, map] : files_) {
        if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
    return names;
}

std::uint64_t EnvironmentLibrary::hash(const std::string& name) const {
    const auto found = files_.find(name);
    return found == files_.end() ? 0 : found->second->contentHash;
}

std::shared_ptr<const EnvironmentMap> EnvironmentLibrary::require(const std::string& name) {
    auto uploaded = upload(name);
    return uploaded ? uploaded : find(name);
}

EnvironmentLibrary::Leases EnvironmentLibrary::requireUploads(const FrameRequest& request) {
    Leases leases;
    for (const NamedMap& named : mapsNamedBy(request)) {
        try {
            if (auto map = upload(named.name)) leases.push_back(std::move(map));
        } catch (const RequestError& error) {
            Problem problem = error.problem();
            problem.errors = {{named.pointer, "could not be loaded", "another environment map"}};
            throw RequestError(std::move(problem));
        }
    }
    return leases;
}

// Null if it is not the name of a stored upload.
std::shared_ptr<const EnvironmentMap> EnvironmentLibrary::upload(const std::string& name) {
    if (!uploads_ || !UploadStore::isId(name)) return nullptr;
    const auto stored = uploads_->find(name);
    if (!stored || !stored->isMap) {
        // Another process may have deleted it.
        const std::lock_guard lock(mutex_);
        loaded_.erase(name);
        return nullptr;
    }
    if (auto map = loadedUpload(name)) return map;
    const std::lock_guard one(loading_);
    if (auto map = loadedUpload(name)) return map;
    return load(*stored);
}

std::shared_ptr<const EnvironmentMap> EnvironmentLibrary::loadedUpload(const std::string& name) {
    const std::lock_guard lock(mutex_);
    const auto found = loaded_.find(name);
    if (found == loaded_.end()) return nullptr;
    found->second.lastUsed = ++uses_;
    return found->second.lease;
}

std::shared_ptr<const EnvironmentMap> EnvironmentLibrary::load(const Upload& upload) {
    std::shared_ptr<const EnvironmentMap> map;
    try {
        EnvironmentMap read = loadEnvironment(upload.file, importUploads_);
        read.name = upload.id;
        read.title = upload.title;
        map = std::make_shared<const EnvironmentMap>(std::move(read));
    } catch (const ImportError& error) {
        logError({"environment map ", upload.id, ": ", error.what()});
        throw RequestError(mapFailed(error.what(), std::string(nameOf(error.reason()))));
    }
    queue_.post([map](Renderer& renderer) { renderer.addEnvironment(map); });
    // The renderer holds the map itself, and releases it when the last lease ends.
    const std::shared_ptr<const EnvironmentMap> lease(
        map.get(), [map, &queue = queue_](const EnvironmentMap*) {
            queue.post([map](Renderer& renderer) { renderer.removeEnvironment(*map); });
        });
    const std::lock_guard lock(mutex_);
    makeRoom(bytesOf(*map));
    loaded_[upload.id] = {lease, ++uses_};
    return lease;
}

// With the lock held.
void EnvironmentLibrary::makeRoom(std::uint64_t bytes) {
    for (const auto& [name, one] : loaded_) bytes += bytesOf(*one.lease);
    while (bytes > kUploadedMapBytes) {
        auto oldest = loaded_.end();
        for (auto one = loaded_.begin(); one != loaded_.end(); ++one) {
            const bool isFree = one->second.lease.use_count() == 1;
            if (isFree &&
                (oldest == loaded_.end() || one->second.lastUsed < oldest->second.lastUsed)) {
                oldest = one;
            }
        }
        if (oldest == loaded_.end()) return;
        bytes -= bytesOf(*oldest->second.lease);
        loaded_.erase(oldest);
    }
}

std::vector<MapStatus> EnvironmentLibrary::all() const {
    std::vector<MapStatus> list;
    for (const std::string& name : names()) {
        const auto file = files_.find(name);
        if (file == files_.end()) {
            list.push_back({name, name, MapSource::builtIn});
        } else {
            list.push_back({name, file->second->title, MapSource::file});
        }
    }
    if (!uploads_) return list;
    for (const Upload& upload : uploads_->all()) {
        if (upload.isMap) list.push_back({upload.id, upload.title, MapSource::uploaded});
    }
    return list;
}

MapStatus EnvironmentLibrary::status(const std::string& name) const {
    const std::vector<MapStatus> known = all();
    const auto found = std::find_if(known.begin(), known.end(),
                                    [&](const MapStatus& map) { return map.name == name; });
    if (found != known.end()) return *found;
    std::vector<std::string_view> names;
    for (const MapStatus& map : known) names.push_back(map.name);
    throw RequestError(notFound("There is no such environment map" + didYouMean(name, names)));
}

void EnvironmentLibrary::remove(const std::string& name) {
    if (status(name).source != MapSource::uploaded) {
        throw RequestError(forbidden("Only environment maps that were uploaded can be deleted."));
    }
    const std::lock_guard lock(mutex_);
    loaded_.erase(name);
}

std::uint64_t EnvironmentLibrary::uploadedBytes() const {
    std::uint64_t bytes = 0;
    const std::lock_guard lock(mutex_);
    for (const auto& [name, one] : loaded_) bytes += bytesOf(*one.lease);
    return bytes;
}

}  // namespace clerestory
