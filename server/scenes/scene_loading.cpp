// SceneLibrary: the thread that loads scenes.
#include "scene/builtin/builtin_scenes.h"
#include "server/base/log.h"
#include "server/scenes/scene_library.h"
#include "server/scenes/shader_cache.h"

#include <malloc.h>

namespace clerestory {
namespace {

// Attempts to load an upload that each ended their process.
constexpr std::uint64_t kMaxTries = 3;

// After a failure that is not the scene's own.
constexpr std::chrono::seconds kRetryInterval{2};

// How soon a loader that waits for the renderer sees that the library ends.
constexpr std::chrono::milliseconds kEndPollInterval{50};

class CrashesRenderer : public ImportError {
public:
    CrashesRenderer()
        : ImportError(Reason::crashed,
                      "the renderer ended more than once while it loaded this scene") {}
};

// Ends an import when the library ends.
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

// A copy without the data that only the renderer needs, which is nearly all of its memory.
static Scene copyForDescription(Scene& scene) {
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
        requireSafe(*entry);
        const auto full = std::make_shared<Scene>(make(*entry));
        const auto known = std::make_shared<const Scene>(copyForDescription(*full));
        const std::size_t vertices = full->vertices.size();
        std::optional<Scene> copy;
        if (WarmUps::needsCopy(*full)) copy = copyWithoutTexels(*full);
        std::future<std::uint64_t> taken = addToRenderer(entry, full, copy.has_value());
        if (!taken.valid() || !waitFor(taken)) return;
        setReady(entry, known, vertices, taken.get());
        warmUp(*known, std::move(copy));
        logInfo({"scene ", known->id, ": ", std::to_string(triangleCount(*known)), " triangles in ",
                 fixedPoint(millisecondsSince(start), 0), " ms"});
    } catch (const std::exception& error) {
        setFailed(entry, error);
    }
}

// The bytes of the meshes that the renderer shares, when it has the scene. Not valid if the scene
// was deleted. isNew: its programs were never compiled.
std::future<std::uint64_t> SceneLibrary::addToRenderer(const Entry& entry,
                                                       const std::shared_ptr<Scene>& full,
                                                       bool isNew) {
    const SceneBytes bytes = bytesOf(*full);
    const std::lock_guard lock(mutex_);
    if (entry->isDeleted) {
        entry->status.state = SceneState::waiting;
        remove(entry);
        return {};
    }
    makeRoom(bytes.total());
    entry->status.bytes = bytes;
    loadedBytes_ += bytes.total();
    auto add = std::make_shared<std::packaged_task<std::uint64_t(Renderer&)>>(
        [full, isNew](Renderer& renderer) {
            const std::uint64_t before = renderer.counters().bytesShared;
            const std::string id = full->id;
            renderer.addScene(std::move(*full));
            renderer.expectCompilation(id, isNew);
            malloc_trim(0);  // loading a large scene fragments the heap
            return renderer.counters().bytesShared - before;
        });
    queue_.post([add](Renderer& renderer) { (*add)(renderer); });
    return add->get_future();
}

// A mark in the shader cache records that this build has compiled the default scene.
void SceneLibrary::warmUp(const Scene& known, std::optional<Scene> copy) {
    std::function<void()> whenFinished;
    if (known.id == defaultId_) {
        whenFinished = [name = firstSource_] { setCompiled(name); };
    }
    warmUps_.begin(known, std::move(copy), environments_.fromFiles(), std::move(whenFinished));
}

// Returns false if the library ends first: the renderer may never answer.
bool SceneLibrary::waitFor(const std::future<std::uint64_t>& work) {
    while (work.wait_for(kEndPollInterval) != std::future_status::ready) {
        const std::lock_guard lock(mutex_);
        if (ending_) return false;
    }
    return true;
}

void SceneLibrary::setReady(const Entry& entry, const std::shared_ptr<const Scene>& known,
                            std::size_t vertices, std::uint64_t sharedBytes) {
    const std::lock_guard lock(mutex_);
    SceneStatus& status = entry->status;
    status.bytes.meshes -= sharedBytes;  // bytesOf() counts both sides
    loadedBytes_ -= sharedBytes;
    status.scene = known;
    status.vertices = vertices;
    if (!status.uploaded && !known->title.empty()) status.title = known->title;
    status.progress = {.stage = "", .progress = 1.0};
    status.state = SceneState::ready;
    entries_.addScenesOfFile(entry, *known);
    if (status.uploaded) uploads_->endLoading(entry->fileId);
    if (entry->isDeleted) remove(entry);
    changed_.notify_all();
}

void SceneLibrary::setFailed(const Entry& entry, const std::exception& error) {
    logError({"scene ", entry->status.id, ": ", error.what()});
    const auto* why = dynamic_cast<const ImportError*>(&error);
    const std::lock_guard lock(mutex_);
    SceneStatus& status = entry->status;
    status.state = SceneState::failed;
    if (!why) entry->retryAt = Clock::now() + kRetryInterval;
    status.failure = why ? why->what() : "The scene could not be loaded.";
    status.reason = why ? nameOf(why->reason()) : "internal";
    loadedBytes_ -= status.bytes.total();
    status.bytes = {};
    if (status.uploaded) {
        // Other processes do not try it again.
        const bool isFile = entry->fileId == status.id;
        if (why && isFile) uploads_->setFailure(status.id, status.failure, status.reason);
        if (!dynamic_cast<const CrashesRenderer*>(&error)) uploads_->endLoading(entry->fileId);
    }
    if (entry->isDeleted) remove(entry);
    changed_.notify_all();
}

// Throws for an upload that has ended its process in each attempt.
void SceneLibrary::requireSafe(const SceneEntry& entry) {
    if (!entry.status.uploaded || entry.isSafe) return;
    if (uploads_->beginLoading(entry.fileId) < kMaxTries) return;
    throw CrashesRenderer();
}

Scene SceneLibrary::make(SceneEntry& entry) {
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
    // The entry of the file holds the names for all of its scenes.
    if (entry.fileId != entry.status.id) {
        scene.scenesOfFile = {};
        scene.sceneOfFile = 0;
    }
    requireLight(scene);
    return scene;
}

// The scene's sidecar file may name a map that is not loaded.
void SceneLibrary::requireLight(Scene& scene) const {
    if (!environments_.has(scene.environment)) lightWithSky(scene);
}

}  // namespace clerestory
