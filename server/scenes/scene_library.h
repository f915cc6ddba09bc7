// The scenes and their loading. The scenes that the options name load at the start, all others when
// they are first requested, on one background thread, which passes them to the Renderer through the
// queue. If loaded scenes exceed the memory limit, the least recently used one that is not in use
// is evicted; it loads again when it is requested. Thread-safe.
#pragma once

#include "server/queue/render_queue.h"
#include "server/scenes/environment_library.h"
#include "server/scenes/scene_entries.h"
#include "server/scenes/warm_ups.h"

#include <condition_variable>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace clerestory {

// Sums over all scenes.
struct SceneTotals {
    SceneBytes bytes;           // of loaded ones
    std::size_t loaded = 0;     // scenes
    std::uint64_t evicted = 0;  // scenes, since the start
    std::size_t uploads = 0;
    std::uint64_t uploadedMapBytes = 0;
};

class SceneLibrary {
public:
    // Loads the environment maps, and starts to load scenes. Throws std::runtime_error with a
    // one-line message if a source does not exist.
    // work: of compiling programs in advance.
    SceneLibrary(const SceneSources& sources, RenderQueue& queue, const RendererOptions& options,
                 std::shared_ptr<BackgroundWork> work);
    ~SceneLibrary();
    SceneLibrary(const SceneLibrary&) = delete;
    SceneLibrary& operator=(const SceneLibrary&) = delete;

    const std::string& defaultId() const { return defaultId_; }
    std::vector<SceneStatus> all();
    SceneTotals totals() const;

    // Requests the scene if it was never loaded. Throws RequestError 404.
    SceneStatus find(const std::string& id);
    // The progress of compiling the shaders of a loaded scene.
    WarmUps::Progress warmUp(const std::string& id) const { return warmUps_.of(id); }
    // Whether the default scene is loaded and its shaders are compiled, or its loading has failed.
    bool defaultIsWarm();

    // The scene, loaded; the default scene if the id is empty. It is not evicted as long as the
    // result exists, which must not outlive this. Waits a moment for a scene that loads. Throws
    // RequestError: no such scene (404), still loading (409), failed (422).
    std::shared_ptr<const Scene> require(const std::string& id);

    // The same of the scenes of FrameRequest::parts; none if that is empty.
    std::vector<std::shared_ptr<const Scene>> requireParts(const FrameRequest& request);

    // A new copy of the scene with vertices and texels. Takes as long as loading it. Throws
    // RequestError 404, ImportError.
    Scene whole(const std::string& id);

    // The ids of the loaded scenes, the most recently used one last.
    std::vector<std::string> loadedScenes() const;
    // The same with their content hashes.
    std::vector<std::pair<std::string, std::uint64_t>> loadedContents() const;
    // Loads these scenes, too, after those that clients request; another process has loaded them.
    // Ignores unknown ids.
    void load(const std::vector<std::string>& ids);

    // Deletes an upload: it is not found any more, and is removed after its last frame. Throws
    // RequestError: no such scene (404), not an upload (403).
    void remove(const std::string& id);

    // Records the memory of the maps of one of its frames.
    void recordMapBytes(const std::string& id, std::uint64_t bytes);
    // Records where the progress of its light is found; see Frame::lightNow.
    void recordLight(const std::string& id, std::function<LightProgress()> now);

    EnvironmentLibrary& environments() { return environments_; }
    const EnvironmentLibrary& environments() const { return environments_; }

    // A file is being imported, which can take long and cannot be interrupted.
    bool importing() const;

private:
    using Entry = SceneEntries::Entry;
    void updateUploads(std::unique_lock<std::mutex>& lock);
    void request(const Entry& entry, bool first);
    Entry entryFor(const std::string& id, std::unique_lock<std::mutex>& lock);
    ImportOptions importFor(const SceneEntry& entry) const;
    void requireFile(const Entry& file);
    void loadAll();
    void load(const Entry& entry);
    void setFailed(const Entry& entry, const std::exception& error);
    void warmUp(const Scene& known, std::optional<Scene> copy);
    std::future<std::uint64_t> addToRenderer(const Entry& entry, const std::shared_ptr<Scene>& full,
                                             bool isNew);
    bool waitFor(const std::future<std::uint64_t>& work);
    void setReady(const Entry& entry, const std::shared_ptr<const Scene>& known,
                  std::size_t vertices, std::uint64_t sharedBytes);
    void requireSafe(const SceneEntry& entry);
    void requireLight(Scene& scene) const;
    Scene make(SceneEntry& entry);
    void release(const Entry& entry);
    void remove(const Entry& entry);
    void makeRoom(std::uint64_t bytes);
    void evict(SceneEntry& entry);

    RenderQueue& queue_;
    const ImportOptions import_;
    const std::string firstSource_;  // of the default scene
    const std::uint64_t memoryBytes_;
    const std::shared_ptr<UploadStore> uploads_;  // null: not allowed
    const ImportOptions importUploads_;
    EnvironmentLibrary environments_;
    std::string defaultId_;

    std::mutex updating_;  // while the folder of uploads is read; locked before mutex_
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    SceneEntries entries_;
    std::deque<Entry> toLoad_;
    std::uint64_t uses_ = 0, evicted_ = 0, loadedBytes_ = 0;
    bool ending_ = false;
    WarmUps warmUps_;
    std::thread loader_;
};

}  // namespace clerestory
