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

std::optional<Clock::time_point> untilOf(MapPatience patience) {
    if (patience == kUnlimitedMapPatience) return std::nullopt;
    return Clock::now() +
           std::chrono::duration_cast<Clock::duration>(std::min(patience, kMapPatience));
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

EnvironmentLibrary::~EnvironmentLibrary() {
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
    }
    changed_.notify_all();
    if (loader_.joinable()) loader_.join();
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
    auto uploaded = upload(name, untilOf(kMapPatience));
    return uploaded ? uploaded : find(name);
}

EnvironmentLibrary::Leases EnvironmentLibrary::requireUploads(const FrameRequest& request,
                                                              MapPatience patience) {
    const Until until = untilOf(patience);
    Leases leases;
    for (const NamedMap& named : mapsNamedBy(request)) {
        try {
            if (auto map = upload(named.name, until)) leases.push_back(std::move(map));
        } catch (const RequestError& error) {
            Problem problem = error.problem();
            if (problem.code != ProblemCode::mapFailed) throw;
            problem.errors = {{named.pointer, "could not be loaded", "another environment map"}};
            throw RequestError(std::move(problem));
        }
    }
    return leases;
}

// Null if it is not the name of a stored upload.
std::shared_ptr<const EnvironmentMap> EnvironmentLibrary::upload(const std::string& name,
                                                                 Until until) {
    if (!uploads_ || !UploadStore::isId(name)) return nullptr;
    const auto stored = uploads_->find(name);
    std::unique_lock lock(mutex_);
    if (!stored || !stored->isMap) {
        forget(name);  // another process may have deleted it
        return nullptr;
    }
    if (auto map = loadedUpload(name)) return map;
    const std::shared_ptr<Import> import = importOf(*stored);
    await(*import, until, lock);
    if (!import->outcome) {
        throw RequestError(stillLoading("The environment map " + name + " is loading."));
    }
    if (import->outcome->lease) return import->outcome->lease;
    // A later request tries again.
    const auto known = imports_.find(name);
    if (known != imports_.end() && known->second == import) imports_.erase(known);
    throw RequestError(*import->outcome->failure);
}

// With the lock held.
std::shared_ptr<const EnvironmentMap> EnvironmentLibrary::loadedUpload(const std::string& name) {
    const auto found = loaded_.find(name);
    if (found == loaded_.end()) return nullptr;
    found->second.lastUsed = ++uses_;
    return found->second.lease;
}

// With the lock held: the import that was requested before, or a new one.
std::shared_ptr<EnvironmentLibrary::Import> EnvironmentLibrary::importOf(const Upload& upload) {
    if (!loader_.joinable()) loader_ = std::thread([this] { loadAll(); });
    std::shared_ptr<Import>& import = imports_[upload.id];
    if (!import) {
        import = std::make_shared<Import>(Import{.upload = upload, .outcome = {}});
        toLoad_.push_back(import);
        changed_.notify_all();
    }
    return import;
}

// With the lock held.
void EnvironmentLibrary::await(const Import& import, Until until,
                               std::unique_lock<std::mutex>& lock) {
    const auto isOver = [&] { return import.outcome || ending_; };
    if (!until) return changed_.wait(lock, isOver);
    if (waitingCalls_ >= kMaxWaitingForMaps) return;
    ++waitingCalls_;
    changed_.wait_until(lock, *until, isOver);
    --waitingCalls_;
}

void EnvironmentLibrary::loadAll() {
    std::unique_lock lock(mutex_);
    for (;;) {
        changed_.wait(lock, [&] { return ending_ || !toLoad_.empty(); });
        if (ending_) return;
        const std::shared_ptr<Import> import = std::move(toLoad_.front());
        toLoad_.pop_front();
        lock.unlock();
        Outcome outcome = load(import->upload);
        lock.lock();
        if (outcome.lease) {
            makeRoom(bytesOf(*outcome.lease));
            loaded_[import->upload.id] = {outcome.lease, ++uses_};
            imports_.erase(import->upload.id);
        }
        import->outcome = std::move(outcome);
        changed_.notify_all();
    }
}

EnvironmentLibrary::Outcome EnvironmentLibrary::load(const Upload& upload) {
    std::shared_ptr<const EnvironmentMap> map;
    try {
        EnvironmentMap read = loadEnvironment(upload.file, importUploads_);
        read.name = upload.id;
        read.title = upload.title;
        map = std::make_shared<const EnvironmentMap>(std::move(read));
    } catch (const ImportError& error) {
        logError({"environment map ", upload.id, ": ", error.what()});
        return {{}, mapFailed(error.what(), std::string(nameOf(error.reason())))};
    } catch (const std::exception& error) {
        logError({"environment map ", upload.id, ": ", error.what()});
        return {{}, internalError()};
    }
    queue_.post([map](Renderer& renderer) { renderer.addEnvironment(map); });
    // The renderer holds the map itself, and releases it when the last lease ends.
    const auto end = [map, &queue = queue_](const EnvironmentMap*) {
        queue.post([map](Renderer& renderer) { renderer.removeEnvironment(*map); });
    };
    return {{map.get(), end}, {}};
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
    forget(name);
}

// With the lock held. An import in progress is finished.
void EnvironmentLibrary::forget(const std::string& name) {
    loaded_.erase(name);
    const auto known = imports_.find(name);
    if (known != imports_.end() && known->second->outcome) imports_.erase(known);
}

std::uint64_t EnvironmentLibrary::uploadedBytes() const {
    std::uint64_t bytes = 0;
    const std::lock_guard lock(mutex_);
    for (const auto& [name, one] : loaded_) bytes += bytesOf(*one.lease);
    return bytes;
}

std::size_t EnvironmentLibrary::waitingCalls() const {
    const std::lock_guard lock(mutex_);
    return waitingCalls_;
}

}  // namespace clerestory
