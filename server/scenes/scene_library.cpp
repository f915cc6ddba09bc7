#include "server/scenes/scene_library.h"

#include "scene/builtin/builtin_scenes.h"
#include "scene/spelling.h"
#include "server/base/log.h"
#include "server/base/problem.h"

#include <malloc.h>

#include <algorithm>

namespace clerestory {
namespace {

// How long a call waits for a scene that loads: for the first time, and after an eviction.
constexpr std::chrono::milliseconds kLoadPatience{1000}, kReloadPatience{5000};

std::string percent(double share) {
    return std::to_string(static_cast<int>(100.0 * share)) + " %";
}

std::shared_ptr<UploadStore> storeOf(const UploadOptions& uploads) {
    if (uploads.folder.empty()) return nullptr;
    return std::make_shared<UploadStore>(uploads.folder, uploads.limits);
}

ImportOptions importOfUploads(const SceneSources& sources) {
    ImportOptions options{.importer = sources.import.importer,
                          .limits = sources.uploads.import,
                          .cache = sources.import.cache};
    options.limits.fileBytes = sources.uploads.limits.fileBytes;
    options.limits.maxDrawn = options.limits.maxTriangles;
    return options;
}

}  // namespace

SceneLibrary::SceneLibrary(const SceneSources& sources, RenderQueue& queue,
                           const RendererOptions& options, std::shared_ptr<BackgroundWork> work)
    : queue_(queue),
      import_(sources.import),
      firstSource_(firstSourceOf(sources)),
      memoryBytes_(sources.memoryBytes),
      uploads_(storeOf(sources.uploads)),
      importUploads_(importOfUploads(sources)),
      environments_(sources.environments, import_, uploads_, importUploads_, queue),
      entries_(sources),
      warmUps_(queue, options, std::move(work)) {
    std::unique_lock lock(mutex_);
    updateUploads(lock);
    defaultId_ = entries_.first().front()->status.id;
    for (const Entry& entry : entries_.first()) {
        request(entry, false);
    }
    loader_ = std::thread([this] { loadAll(); });
}

SceneLibrary::~SceneLibrary() {
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
    }
    changed_.notify_all();
    loader_.join();
}

// With the lock held, which is released while the folder is read: a disk may be slow, and other
// calls, such as those of the heartbeat, do not need it.
void SceneLibrary::updateUploads(std::unique_lock<std::mutex>& lock) {
    if (!uploads_) return;
    lock.unlock();
    const std::lock_guard one(updating_);  // a later reading is not overwritten by an earlier one
    const std::vector<Upload> stored = uploads_->all();
    lock.lock();
    for (const Entry& entry : entries_.updateUploads(stored)) remove(entry);
}

std::vector<SceneStatus> SceneLibrary::all() {
    std::unique_lock lock(mutex_);
    updateUploads(lock);
    std::vector<SceneStatus> list;
    for (const Entry& entry : entries_.listed()) {
        const SceneStatus& status = entry->status;
        // The client that sent it knows.
        if (status.uploaded && status.state == SceneState::failed) continue;
        list.push_back(status);
    }
    return list;
}

SceneTotals SceneLibrary::totals() const {
    const std::lock_guard lock(mutex_);
    SceneTotals totals{.evicted = evicted_, .uploadedMapBytes = environments_.uploadedBytes()};
    for (const Entry& entry : entries_.listed()) {
        const SceneStatus& status = entry->status;
        totals.uploads += status.uploaded;
        totals.loaded += status.state == SceneState::ready;
        totals.bytes.meshes += status.bytes.meshes;
        totals.bytes.textures += status.bytes.textures;
        totals.bytes.maps += status.bytes.maps;
    }
    return totals;
}

// With the lock held; see updateUploads(). Looks for new uploads of other processes first, unless
// the scene is certainly there.
SceneLibrary::Entry SceneLibrary::entryFor(const std::string& id,
                                           std::unique_lock<std::mutex>& lock) {
    Entry entry = entries_.find(id);
    const bool certain =
        entry && (!entry->status.uploaded || entry->status.state == SceneState::ready);
    if (!certain) {
        updateUploads(lock);
        entry = entries_.find(id);
    }
    // Another process, which has ended since, may have deleted it.
    if (entry && entry->status.uploaded && uploads_ && !uploads_->find(entry->fileId)) {
        updateUploads(lock);
        entry = entries_.find(id);
    }
    if (entry) return entry;
    if (const Entry file = entries_.findFile(id)) {
        requireFile(file);
        entry = entries_.find(id);
        if (entry) return entry;
    }
    const std::vector<Entry> listed = entries_.listed();
    std::vector<std::string_view> known;
    for (const Entry& one : listed) known.push_back(one->status.id);
    Problem problem = notFound("There is no such scene" + didYouMean(id, known));
    problem.errors = {
        {"/scene", "is not the id of a scene" + didYouMean(id, known), clerestory::listed(known)}};
    throw RequestError(std::move(problem));
}

// With the lock held: the other scenes of a file are known when its default scene was loaded.
void SceneLibrary::requireFile(const Entry& file) {
    if (file->status.scene) return entries_.addScenesOfFile(file, *file->status.scene);
    request(file, true);
    if (file->status.state == SceneState::failed) {
        throw RequestError(sceneFailed(file->status.failure, file->status.reason));
    }
    throw RequestError(stillLoading(file->status.id + ", the default scene of the file, is " +
                                    std::string(nameOf(file->status.state)) + "."));
}

void SceneLibrary::request(const Entry& entry, bool first) {
    if (first && entry->status.state == SceneState::waiting && entry->isRequested) {
        std::erase(toLoad_, entry);
        entry->isRequested = false;
    }
    if (entry->status.state == SceneState::failed && Clock::now() >= entry->retryAt) {
        entry->status.state = SceneState::waiting;
        entry->retryAt = Clock::time_point::max();
        entry->isRequested = false;
    }
    if (entry->isRequested) return;
    entry->isRequested = true;
    toLoad_.insert(first ? toLoad_.begin() : toLoad_.end(), entry);
    changed_.notify_all();
}

SceneStatus SceneLibrary::find(const std::string& id) {
    std::unique_lock lock(mutex_);
    const Entry entry = entryFor(id, lock);
    if (!entry->status.scene) request(entry, true);
    return entry->status;
}

bool SceneLibrary::defaultIsWarm() {
    const SceneState state = find(defaultId_).state;
    return state == SceneState::failed ||
           (state == SceneState::ready && warmUps_.of(defaultId_).finished);
}

std::shared_ptr<const Scene> SceneLibrary::require(const std::string& id) {
    std::unique_lock lock(mutex_);
    const Entry entry = entryFor(id.empty() ? defaultId_ : id, lock);
    request(entry, true);
    entry->lastUsed = ++uses_;
    const SceneStatus& status = entry->status;
    ++entry->waiting;
    changed_.wait_for(lock, status.scene ? kReloadPatience : kLoadPatience, [&] {
        return status.state == SceneState::ready || status.state == SceneState::failed || ending_;
    });
    --entry->waiting;
    if (status.state == SceneState::failed) {
        throw RequestError(sceneFailed(status.failure, status.reason));
    }
    if (status.state != SceneState::ready) {
        throw RequestError(
            stillLoading(status.id + " is " + std::string(nameOf(status.state)) +
                         (status.progress.stage.empty() ? "" : ": " + status.progress.stage) +
                         ", " + percent(status.progress.progress) + "."));
    }
    ++entry->users;
    return {status.scene.get(),
            [this, entry, scene = status.scene](const Scene*) { release(entry); }};
}

std::vector<std::string> SceneLibrary::loadedScenes() const {
    std::vector<std::string> ids;
    for (auto& [id, hash] : loadedContents()) ids.push_back(id);
    return ids;
}

std::vector<std::pair<std::string, std::uint64_t>> SceneLibrary::loadedContents() const {
    std::vector<Entry> ready;
    const std::lock_guard lock(mutex_);
    for (const Entry& entry : entries_.listed()) {
        if (entry->status.state == SceneState::ready) ready.push_back(entry);
    }
    std::stable_sort(ready.begin(), ready.end(),
                     [](const Entry& a, const Entry& b) { return a->lastUsed < b->lastUsed; });
    std::vector<std::pair<std::string, std::uint64_t>> contents;
    for (const Entry& entry : ready) {
        contents.emplace_back(entry->status.id, entry->status.scene->contentHash);
    }
    return contents;
}

void SceneLibrary::load(const std::vector<std::string>& ids) {
    std::unique_lock lock(mutex_);
    updateUploads(lock);
    std::vector<Entry> wanted;
    for (const std::string& id : ids) {
        Entry entry = entries_.find(id);
        if (!entry) entry = entries_.findFile(id);
        if (!entry) continue;
        entry->lastUsed = ++uses_;
        entry->isSafe = true;
        wanted.push_back(entry);
    }
    for (auto entry = wanted.rbegin(); entry != wanted.rend(); ++entry) request(*entry, false);
}

void SceneLibrary::release(const Entry& entry) {
    const std::lock_guard lock(mutex_);
    --entry->users;
    if (entry->isDeleted) {
        remove(entry);
    } else if (loadedBytes_ > memoryBytes_) {
        makeRoom(0);
    }
}

std::vector<std::shared_ptr<const Scene>> SceneLibrary::requireParts(const FrameRequest& request) {
    std::vector<std::shared_ptr<const Scene>> scenes;
    for (const PlacedScene& part : request.parts) scenes.push_back(require(part.scene));
    return scenes;
}

Scene SceneLibrary::whole(const std::string& id) {
    Entry entry;
    {
        std::unique_lock lock(mutex_);
        entry = entryFor(id, lock);
    }
    const auto& file = entry->file;
    Scene scene =
        file.empty() ? makeBuiltinScene(id).value() : importScene(file, importFor(*entry));
    scene.id = id;
    requireLight(scene);
    return scene;
}

void SceneLibrary::remove(const std::string& id) {
    std::unique_lock lock(mutex_);
    const Entry entry = entryFor(id, lock);
    if (!entry->status.uploaded) {
        throw RequestError(forbidden("Only scenes that were uploaded can be deleted."));
    }
    if (entry->fileId != entry->status.id) {
        throw RequestError(forbidden("A scene is deleted with its file, " + entry->fileId + "."));
    }
    remove(entry);
}

// With the lock held. A scene in use is removed when its last use ends.
void SceneLibrary::remove(const Entry& entry) {
    entry->isDeleted = true;
    std::erase(toLoad_, entry);
    if (entry->users > 0 || entry->status.state == SceneState::loading) return;
    if (entry->status.state == SceneState::ready) evict(*entry);
    entries_.remove(entry);
}

void SceneLibrary::recordMapBytes(const std::string& id, std::uint64_t bytes) {
    const std::lock_guard lock(mutex_);
    const Entry entry = entries_.find(id);
    if (!entry || bytes <= entry->status.bytes.maps) return;
    loadedBytes_ += bytes - entry->status.bytes.maps;
    entry->status.bytes.maps = bytes;
}

void SceneLibrary::recordLight(const std::string& id, std::function<LightProgress()> now) {
    const std::lock_guard lock(mutex_);
    const Entry entry = entries_.find(id);
    if (entry && entry->status.state == SceneState::ready) entry->status.lightNow = std::move(now);
}

// With the lock held: evicts scenes until there is room for that many bytes. The default scene
// stays, since the server is not ready without it.
void SceneLibrary::makeRoom(std::uint64_t bytes) {
    while (loadedBytes_ + bytes > memoryBytes_) {
        SceneEntry* oldest = nullptr;
        for (const Entry& entry : entries_.listed()) {
            const bool free = entry->status.state == SceneState::ready && entry->users == 0 &&
                              entry->waiting == 0 && entry->status.id != defaultId_;
            if (free && (!oldest || entry->lastUsed < oldest->lastUsed)) oldest = entry.get();
        }
        if (!oldest) return;
        evict(*oldest);
        ++evicted_;
        logInfo({"scene ", oldest->status.id, ": evicted; it loads again when it is requested"});
    }
}

// With the lock held, so that it is not requested again before the renderer's work is queued.
void SceneLibrary::evict(SceneEntry& entry) {
    queue_.post([id = entry.status.id](Renderer& renderer) {
        renderer.removeScene(id);
        malloc_trim(0);
    });
    warmUps_.forget(entry.status.id);
    loadedBytes_ -= entry.status.bytes.total();
    entry.status.bytes = {};
    entry.status.lightNow = {};
    entry.status.state = SceneState::waiting;
    entry.isRequested = false;
}

bool SceneLibrary::importing() const {
    const std::lock_guard lock(mutex_);
    const std::vector<Entry> listed = entries_.listed();
    return std::any_of(listed.begin(), listed.end(), [](const Entry& entry) {
        return entry->status.state == SceneState::loading && !entry->file.empty();
    });
}

ImportOptions SceneLibrary::importFor(const SceneEntry& entry) const {
    ImportOptions options = entry.status.uploaded ? importUploads_ : import_;
    options.scene = entry.sceneOfFile;
    return options;
}

}  // namespace clerestory
