// The library's other half: the thread that loads scenes.
#include "scene/builtin/builtin_scenes.h"
#include "server/base/log.h"
#include "server/scenes/scene_library.h"
#include "server/scenes/scene_light.h"
#include "server/scenes/shader_cache.h"

#include <malloc.h>

namespace clerestory {
namespace {

// To load an upload, when whoever tried it ended each time.
constexpr std::uint64_t kMaxTries = 3;

// After a failure that was not the scene's own, so that hopeless attempts do not fill the time.
constexpr std::chrono::seconds kBetweenTries{2};

// How soon a loader that waits for the renderer sees that it need not.
constexpr std::chrono::milliseconds kLoadingLooksUp{50};

class Harmful : public ImportError {
public:
    Harmful()
        : ImportError(Reason::crashed,
                      "the renderer ended more than once while it loaded this scene") {}
};

// Thrown out of an import when the server stops.
struct Stopping {};

}  // namespace

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
    try {
        requireHarmless(*entry);
        const auto full = std::make_shared<Scene>(made(*entry));
        const auto known = std::make_shared<const Scene>(described(*full));
        const std::size_t vertices = full->vertices.size();
        std::optional<Scene> copy;
        if (WarmUps::wantsCopy(*full)) copy = copyWithoutTexels(*full);
        std::future<std::uint64_t> taken = handed(entry, full);
        if (!taken.valid() || !ended(taken)) return;
        ready(entry, known, vertices, taken.get());
        warmUp(*known, std::move(copy));
        logInfo({"scene ", known->id, ": ", std::to_string(triangleCount(*known)), " triangles in ",
                 fixedPoint(millisecondsSince(start), 0), " ms"});
    } catch (const std::exception& error) {
        failed(entry, error);
    }
}

// To the renderer, once there is room for it. Not valid: nobody wants it any more.
std::future<std::uint64_t> SceneLibrary::handed(const Entry& entry,
                                                const std::shared_ptr<Scene>& full) {
    const SceneBytes bytes = bytesOf(*full);
    const std::lock_guard lock(mutex_);
    if (entry->deleted) {
        entry->status.state = SceneState::waiting;
        remove(entry);
        return {};
    }
    makeRoom(bytes.total());
    entry->status.bytes = bytes;
    loadedBytes_ += bytes.total();
    auto add =
        std::make_shared<std::packaged_task<std::uint64_t(Renderer&)>>([full](Renderer& renderer) {
            const std::uint64_t before = renderer.counters().bytesShared;
            renderer.addScene(std::move(*full));
            malloc_trim(0);  // reading a large scene leaves the heap full of holes
            return renderer.counters().bytesShared - before;
        });
    queue_.post([add](Renderer& renderer) { (*add)(renderer); });
    return add->get_future();
}

// Of the first scene, what another process of this build has compiled is known to those that start.
void SceneLibrary::warmUp(const Scene& known, std::optional<Scene> copy) {
    std::vector<std::shared_ptr<const EnvironmentMap>> maps;
    for (const auto& [name, map] : environments_) maps.push_back(map);
    std::function<void()> whenFinished;
    if (known.id == defaultId_) {
        whenFinished = [name = firstSource_] { setCompiled(name); };
    }
    warmUps_.begin(known, std::move(copy), std::move(maps), std::move(whenFinished));
}

// False: this ends first. There may never be a renderer.
bool SceneLibrary::ended(const std::future<std::uint64_t>& work) {
    while (work.wait_for(kLoadingLooksUp) != std::future_status::ready) {
        const std::lock_guard lock(mutex_);
        if (ending_) return false;
    }
    return true;
}

void SceneLibrary::ready(const Entry& entry, const std::shared_ptr<const Scene>& known,
                         std::size_t vertices, std::uint64_t shared) {
    const std::lock_guard lock(mutex_);
    SceneStatus& status = entry->status;
    status.bytes.meshes -= shared;  // bytesOf() counts both sides
    loadedBytes_ -= shared;
    status.scene = known;
    status.vertices = vertices;
    if (!status.uploaded && !known->title.empty()) status.title = known->title;
    status.progress = {.stage = "", .progress = 1.0};
    status.state = SceneState::ready;
    if (status.uploaded) uploads_->endLoading(status.id);
    if (entry->deleted) remove(entry);
    changed_.notify_all();
}

void SceneLibrary::failed(const Entry& entry, const std::exception& error) {
    logError({"scene ", entry->status.id, ": ", error.what()});
    const auto* why = dynamic_cast<const ImportError*>(&error);
    const std::lock_guard lock(mutex_);
    SceneStatus& status = entry->status;
    status.state = SceneState::failed;
    if (!why) entry->again = Clock::now() + kBetweenTries;
    status.failure = why ? why->what() : "The scene could not be made.";
    status.reason = why ? nameOf(why->reason()) : "internal";
    loadedBytes_ -= status.bytes.total();
    status.bytes = {};
    if (status.uploaded) {
        // So that no other process tries it.
        if (why) uploads_->setFailure(status.id, status.failure, status.reason);
        if (!dynamic_cast<const Harmful*>(&error)) uploads_->endLoading(status.id);
    }
    if (entry->deleted) remove(entry);
    changed_.notify_all();
}

// What ended the renderer's process each time it was loaded is not tried for ever.
void SceneLibrary::requireHarmless(const SceneEntry& entry) {
    if (!entry.status.uploaded || entry.harmless) return;
    if (uploads_->beginLoading(entry.status.id) < kMaxTries) return;
    throw Harmful();
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
    if (!environment(scene.environment)) lightWithSky(scene);
}

}  // namespace clerestory
