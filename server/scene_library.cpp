#include "server/scene_library.h"

#include "scene/builtin/builtin_scenes.h"
#include "scene/spelling.h"
#include "server/problem.h"

#include <malloc.h>
#include <spdlog/spdlog.h>

#include <algorithm>

namespace clerestory {
namespace {

// Loading that ends within this is waited for; longer loading is told to the client. What was
// loaded before had to go for lack of memory, which is no client's concern.
constexpr std::chrono::milliseconds kPatience{1000}, kPatienceAgain{5000};

// Thrown out of an import when the server stops.
struct Stopping {};

std::string percent(double share) {
    return std::to_string(static_cast<int>(100.0 * share)) + " %";
}

}  // namespace

SceneLibrary::SceneLibrary(const SceneSources& sources, RenderQueue& queue)
    : queue_(queue),
      import_(sources.import),
      memoryBytes_(sources.memoryBytes),
      importUploads_({.importer = sources.import.importer,
                      .limits = sources.uploads.import,
                      .cache = sources.import.cache}),
      entries_(sources) {
    for (const auto& source : sources.environments) {
        auto map = std::make_shared<const EnvironmentMap>(loadEnvironment(source, import_));
        environments_[map->name] = map;
        queue_.post([map](Renderer& renderer) { renderer.addEnvironment(map); });
    }
    if (!sources.uploads.folder.empty()) {
        uploads_.emplace(sources.uploads.folder, sources.uploads.limits);
        importUploads_.limits.fileBytes = sources.uploads.limits.fileBytes;
        followUploads();
    }
    defaultId_ = entries_.first().front()->status.id;
    for (const Entry& entry : entries_.first()) {
        entry->warm = true;
        askFor(entry, false);
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

void SceneLibrary::followUploads() {
    if (!uploads_) return;
    for (const Entry& entry : entries_.followUploads(*uploads_)) remove(entry);
}

std::vector<SceneStatus> SceneLibrary::all() {
    const std::lock_guard lock(mutex_);
    followUploads();
    std::vector<SceneStatus> list;
    for (const Entry& entry : entries_.listed()) {
        const SceneStatus& status = entry->status;
        // Whoever sent what gives no scene was told so.
        if (status.uploaded && status.state == SceneState::failed) continue;
        list.push_back(status);
    }
    return list;
}

SceneTotals SceneLibrary::totals() const {
    const std::lock_guard lock(mutex_);
    SceneTotals totals{.evicted = evicted_};
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

// Another process may have taken an upload since. One that is ready needs no look at the disk.
SceneLibrary::Entry SceneLibrary::entryFor(const std::string& id) {
    Entry entry = entries_.find(id);
    const bool sure =
        entry && (!entry->status.uploaded || entry->status.state == SceneState::ready);
    if (!sure) {
        followUploads();
        entry = entries_.find(id);
    }
    if (entry) return entry;
    const std::vector<Entry> listed = entries_.listed();
    std::vector<std::string_view> known;
    for (const Entry& one : listed) known.push_back(one->status.id);
    Problem problem = notFound("There is no such scene" + didYouMean(id, known));
    problem.errors = {
        {"/scene", "is not the id of a scene" + didYouMean(id, known), clerestory::listed(known)}};
    throw RequestError(std::move(problem));
}

void SceneLibrary::askFor(const Entry& entry, bool first) {
    if (first && entry->status.state == SceneState::waiting && entry->asked) {
        std::erase(toLoad_, entry);
        entry->asked = false;
    }
    if (entry->asked) return;
    entry->asked = true;
    toLoad_.insert(first ? toLoad_.begin() : toLoad_.end(), entry);
    changed_.notify_all();
}

SceneStatus SceneLibrary::find(const std::string& id) {
    const std::lock_guard lock(mutex_);
    const Entry entry = entryFor(id);
    if (!entry->status.scene) askFor(entry, true);
    return entry->status;
}

std::shared_ptr<const Scene> SceneLibrary::require(const std::string& id) {
    std::unique_lock lock(mutex_);
    const Entry entry = entryFor(id.empty() ? defaultId_ : id);
    askFor(entry, true);
    entry->lastUsed = ++uses_;
    const SceneStatus& status = entry->status;
    ++entry->waiting;
    changed_.wait_for(lock, status.scene ? kPatienceAgain : kPatience, [&] {
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

void SceneLibrary::release(const Entry& entry) {
    const std::lock_guard lock(mutex_);
    --entry->users;
    if (entry->deleted) {
        remove(entry);
    } else if (loadedBytes_ > memoryBytes_) {
        makeRoom(0, nullptr);
    }
}

Scene SceneLibrary::whole(const std::string& id) {
    Entry entry;
    {
        const std::lock_guard lock(mutex_);
        entry = entryFor(id);
    }
    const auto& file = entry->file;
    Scene scene =
        file.empty() ? makeBuiltinScene(id).value() : importScene(file, importFor(*entry));
    scene.id = id;
    requireLight(scene);
    return scene;
}

void SceneLibrary::remove(const std::string& id) {
    const std::lock_guard lock(mutex_);
    const Entry entry = entryFor(id);
    if (!entry->status.uploaded) {
        throw RequestError(forbidden("Only scenes that were uploaded can be deleted."));
    }
    remove(entry);
}

// With the lock held. Who draws it keeps it until then.
void SceneLibrary::remove(const Entry& entry) {
    entry->deleted = true;
    std::erase(toLoad_, entry);
    if (entry->users > 0 || entry->status.state == SceneState::loading) return;
    if (entry->status.state == SceneState::ready) letGo(*entry);
    entries_.drop(entry);
}

void SceneLibrary::mapsTook(const std::string& id, std::uint64_t bytes) {
    const std::lock_guard lock(mutex_);
    const Entry entry = entries_.find(id);
    if (!entry || bytes <= entry->status.bytes.maps) return;
    loadedBytes_ += bytes - entry->status.bytes.maps;
    entry->status.bytes.maps = bytes;
}

// With the lock held: for so many bytes more. The default scene stays: a server without it is not
// ready.
void SceneLibrary::makeRoom(std::uint64_t bytes, const Entry& keep) {
    while (loadedBytes_ + bytes > memoryBytes_) {
        SceneEntry* oldest = nullptr;
        for (const Entry& entry : entries_.listed()) {
            const bool free = entry->status.state == SceneState::ready && entry->users == 0 &&
                              entry->waiting == 0 && entry != keep &&
                              entry->status.id != defaultId_;
            if (free && (!oldest || entry->lastUsed < oldest->lastUsed)) oldest = entry.get();
        }
        if (!oldest) return;
        letGo(*oldest);
        ++evicted_;
        spdlog::info("scene {}: let go, to be loaded again when it is asked for",
                     oldest->status.id);
    }
}

// With the lock held, so that nobody asks for it anew before the renderer is told.
void SceneLibrary::letGo(SceneEntry& entry) {
    queue_.post([id = entry.status.id](Renderer& renderer) {
        renderer.removeScene(id);
        malloc_trim(0);
    });
    loadedBytes_ -= entry.status.bytes.total();
    entry.status.bytes = {};
    entry.status.state = SceneState::waiting;
    entry.asked = false;
}

std::shared_ptr<const EnvironmentMap> SceneLibrary::environment(const std::string& name) const {
    const auto found = environments_.find(name);
    if (found != environments_.end()) return found->second;
    auto builtin = builtinEnvironment(name);
    return builtin ? std::make_shared<const EnvironmentMap>(*std::move(builtin)) : nullptr;
}

bool SceneLibrary::importing() const {
    const std::lock_guard lock(mutex_);
    const std::vector<Entry> listed = entries_.listed();
    return std::any_of(listed.begin(), listed.end(), [](const Entry& entry) {
        return entry->status.state == SceneState::loading && !entry->file.empty();
    });
}

std::vector<std::string> SceneLibrary::environmentNames() const {
    std::vector<std::string> names = builtinEnvironmentNames();
    for (const auto& [name, map] : environments_) {
        if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
    return names;
}

std::uint64_t SceneLibrary::environmentHash(const std::string& name) const {
    const auto found = environments_.find(name);
    return found == environments_.end() ? 0 : found->second->contentHash;
}

const ImportOptions& SceneLibrary::importFor(const SceneEntry& entry) const {
    return entry.status.uploaded ? importUploads_ : import_;
}

void SceneLibrary::loadAll() {
    std::unique_lock lock(mutex_);
    for (;;) {
        changed_.wait(lock, [&] { return ending_ || !toLoad_.empty(); });
        if (ending_) return;
        const Entry entry = toLoad_.front();
        toLoad_.pop_front();
        entry->status.state = SceneState::loading;
        lock.unlock();
        try {
            load(entry);
        } catch (const Stopping&) {
            return;
        }
        lock.lock();
    }
}

// What is told about a scene, without what only the renderer needs: nearly all of its memory.
static Scene described(Scene& scene) {
    std::vector<TextureImage> images = std::move(scene.images);
    std::vector<Vertex> vertices = std::move(scene.vertices);
    std::vector<std::uint32_t> indices = std::move(scene.indices);
    std::vector<Deformation> deformations = std::move(scene.deformations);
    Scene result = scene;
    for (TextureImage& image : images) {
        std::vector<std::uint8_t> texels = std::exchange(image.texels, {});
        result.images.push_back(image);
        image.texels = std::move(texels);
    }
    scene.images = std::move(images);
    scene.vertices = std::move(vertices);
    scene.indices = std::move(indices);
    scene.deformations = std::move(deformations);
    return result;
}

void SceneLibrary::load(const Entry& entry) {
    const auto start = Clock::now();
    std::optional<Scene> scene;
    try {
        scene = made(*entry);
    } catch (const std::exception& error) {
        return failed(entry, error);
    }
    hand(entry, *std::move(scene), millisecondsSince(start));
}

void SceneLibrary::failed(const Entry& entry, const std::exception& error) {
    spdlog::error("scene {}: {}", entry->status.id, error.what());
    const auto* why = dynamic_cast<const ImportError*>(&error);
    const std::lock_guard lock(mutex_);
    SceneStatus& status = entry->status;
    status.state = SceneState::failed;
    status.failure = why ? why->what() : "The scene could not be made.";
    status.reason = why ? nameOf(why->reason()) : "internal";
    // So that no other process tries it.
    if (uploads_ && status.uploaded && why) {
        uploads_->setFailure(status.id, status.failure, status.reason);
    }
    if (entry->deleted) remove(entry);
    changed_.notify_all();
}

// To the renderer, once there is room for it.
void SceneLibrary::hand(const Entry& entry, Scene scene, double milliseconds) {
    const auto full = std::make_shared<Scene>(std::move(scene));
    const auto known = std::make_shared<const Scene>(described(*full));
    const SceneBytes bytes = bytesOf(*full);
    const std::string id = entry->status.id;
    const std::lock_guard lock(mutex_);
    if (ending_) return;  // a start that failed says why and nothing else
    SceneStatus& status = entry->status;
    status.state = SceneState::waiting;
    if (entry->deleted) return remove(entry);
    makeRoom(bytes.total(), entry);
    status.vertices = full->vertices.size();
    queue_.post([full](Renderer& renderer) {
        renderer.addScene(std::move(*full));
        malloc_trim(0);  // reading a large scene leaves the heap full of holes
    });
    // A frame that somebody waits for warms what it needs, sooner.
    if (entry->warm && entry->waiting == 0) {
        queue_.post([id](Renderer& renderer) { renderer.warm(id); });
    }
    spdlog::info("scene {}: {} triangles in {:.0f} ms", id, triangleCount(*known), milliseconds);
    status.scene = known;
    status.bytes = bytes;
    loadedBytes_ += bytes.total();
    if (!status.uploaded && !known->title.empty()) status.title = known->title;
    status.progress = {.stage = "", .progress = 1.0};
    status.state = SceneState::ready;
    changed_.notify_all();
}

Scene SceneLibrary::made(SceneEntry& entry) {
    Scene scene;
    if (entry.file.empty()) {
        scene = makeBuiltinScene(entry.status.id).value();
    } else {
        scene = importScene(entry.file, importFor(entry), [&](const ImportProgress& progress) {
            const std::lock_guard lock(mutex_);
            if (ending_) throw Stopping{};
            entry.status.progress = progress;
        });
    }
    scene.id = entry.status.id;
    requireLight(scene);
    return scene;
}

// A side file may name a map that this server was not started with.
void SceneLibrary::requireLight(Scene& scene) const {
    if (environment(scene.environment)) return;
    scene.warnings.push_back({"unknownEnvironment", scene.environment,
                              "no environment map of that name is loaded; 'sky' lights the scene"});
    scene.environment = "sky";
    updateContentHash(scene);
}

}  // namespace clerestory
