// What can be rendered, and how far its loading is. The scenes that were named load at once, all
// others when first asked for, in one background thread; a loaded scene is handed to the Renderer
// through the queue. When they take more memory than they may, the one that was used longest ago is
// let go, unless somebody uses it; it loads again when it is asked for.
#pragma once

#include "server/queue/render_queue.h"
#include "server/scenes/scene_entries.h"
#include "server/scenes/warm_ups.h"

#include <condition_variable>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace clerestory {

// Of all scenes together.
struct SceneTotals {
    SceneBytes bytes;           // of loaded ones
    std::size_t loaded = 0;     // scenes
    std::uint64_t evicted = 0;  // since the start
    std::size_t uploads = 0;
};

class SceneLibrary {
public:
    // Loads the environment maps here and starts to load scenes. Throws std::runtime_error with one
    // line about a source that is not there.
    SceneLibrary(const SceneSources& sources, RenderQueue& queue, const RendererOptions& options);
    ~SceneLibrary();
    SceneLibrary(const SceneLibrary&) = delete;
    SceneLibrary& operator=(const SceneLibrary&) = delete;

    const std::string& defaultId() const { return defaultId_; }
    std::vector<SceneStatus> all();
    SceneTotals totals() const;

    // Throws RequestError 404 when there is no such id. Asks for a scene of which nothing is known
    // to be loaded.
    SceneStatus find(const std::string& id);
    // How far compiling is for the first frames of a loaded scene.
    WarmUps::Progress warmUp(const std::string& id) const { return warmUps_.of(id); }
    // Whether the default scene has been loaded and its programs compiled, or has failed.
    bool defaultIsWarm();

    // The scene, ready to be drawn; an empty id is the default. It stays so for as long as what is
    // returned lives, which must not be longer than this. Waits a moment for one that loads. Throws
    // RequestError: no such scene (404), still loading (409), failed (422).
    std::shared_ptr<const Scene> require(const std::string& id);

    // The scene once more with vertices and texels, made or read anew, for those that need it
    // whole. Takes as long as loading it did. Throws RequestError 404, ImportError.
    Scene whole(const std::string& id);

    // Those that can be drawn at once, the one that was used last at the end.
    std::vector<std::string> held() const;
    // To hold these, too, in the same order: another process draws them. They load in time, when
    // nobody waits for others; ids that nobody knows are left out.
    void hold(const std::vector<std::string>& ids);

    // Of an upload: nobody finds it any more, and it goes when its last frame is drawn. Throws
    // RequestError: no such scene (404), none that was uploaded (403).
    void remove(const std::string& id);

    // What the maps of a frame of it took.
    void mapsTook(const std::string& id, std::uint64_t bytes);

    // The map that lights a scene, or that a material names; null when there is none.
    std::shared_ptr<const EnvironmentMap> environment(const std::string& name) const;

    // A file is being read; that can take long, and nothing interrupts it.
    bool importing() const;

    // Built-in ones first.
    std::vector<std::string> environmentNames() const;

    // Of a map that was loaded from a file; 0 for the built-in ones.
    std::uint64_t environmentHash(const std::string& name) const;

private:
    using Entry = SceneEntries::Entry;
    void followUploads();
    void askFor(const Entry& entry, bool first);
    Entry entryFor(const std::string& id);
    const ImportOptions& importFor(const SceneEntry& entry) const;
    void loadAll();
    void load(const Entry& entry);
    void failed(const Entry& entry, const std::exception& error);
    void warmUp(const Scene& known, std::optional<Scene> copy);
    // Of the future: bytes of the meshes that are held once.
    std::future<std::uint64_t> handed(const Entry& entry, const std::shared_ptr<Scene>& full);
    bool ended(const std::future<std::uint64_t>& work);
    void ready(const Entry& entry, const std::shared_ptr<const Scene>& known, std::size_t vertices,
               std::uint64_t shared);
    void requireHarmless(const SceneEntry& entry);
    void requireLight(Scene& scene) const;
    Scene made(SceneEntry& entry);
    void release(const Entry& entry);
    void remove(const Entry& entry);
    void makeRoom(std::uint64_t bytes);
    void letGo(SceneEntry& entry);

    RenderQueue& queue_;
    const ImportOptions import_;
    const std::string firstSource_;  // as the command line names it
    const std::uint64_t memoryBytes_;
    std::shared_ptr<UploadStore> uploads_;  // null: nobody may upload
    ImportOptions importUploads_;
    std::string defaultId_;
    std::map<std::string, std::shared_ptr<const EnvironmentMap>> environments_;  // from files

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
