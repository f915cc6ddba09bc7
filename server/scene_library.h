// What can be rendered: ids, where each scene comes from, and how far its loading is. The scenes
// that were named load at once, all others when first asked for, in one background thread; a loaded
// scene is handed to the Renderer through the queue.
//
// Ids are keys of a table. They never become paths.
#pragma once

#include "scene/import/import.h"
#include "server/render_queue.h"

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

struct SceneSources {
    std::vector<std::string> scenes;  // ids of built-in scenes, or files; the first is the default
    std::filesystem::path folder;     // files found below it load when first asked for
    std::vector<std::filesystem::path> environments;
    ImportOptions import;
};

enum class SceneState { waiting, loading, ready, failed };
std::string_view nameOf(SceneState state);

struct SceneStatus {
    std::string id, title;
    SceneState state = SceneState::waiting;
    ImportProgress progress;
    std::string failure;                 // words for people, when failed
    std::shared_ptr<const Scene> scene;  // when ready; without vertices, indices and texels
    std::size_t vertices = 0;
};

class SceneLibrary {
public:
    // Loads the environment maps here and starts to load scenes. Throws std::runtime_error with one
    // line about a source that is not there.
    SceneLibrary(const SceneSources& sources, RenderQueue& queue);
    ~SceneLibrary();
    SceneLibrary(const SceneLibrary&) = delete;
    SceneLibrary& operator=(const SceneLibrary&) = delete;

    const std::string& defaultId() const { return defaultId_; }
    std::vector<SceneStatus> all() const;

    // Throws RequestError 404 when there is no such id. Asks for the scene to be loaded.
    SceneStatus find(const std::string& id);

    // The scene, ready to be drawn; an empty id is the default. Waits a moment for one that loads.
    // Throws RequestError: no such scene (404), still loading (409), failed (422).
    std::shared_ptr<const Scene> require(const std::string& id);

    // The scene once more with vertices and texels, made or read anew, for those that need it
    // whole. Takes as long as loading it did. Throws RequestError 404, ImportError.
    Scene whole(const std::string& id);

    // The map that lights a scene, or that a material names; null when there is none.
    std::shared_ptr<const EnvironmentMap> environment(const std::string& name) const;

    // A file is being read; that can take long, and nothing interrupts it.
    bool importing() const;

    // Built-in ones first.
    std::vector<std::string> environmentNames() const;

    // Of a map that was loaded from a file; 0 for the built-in ones.
    std::uint64_t environmentHash(const std::string& name) const;

private:
    struct Entry {
        SceneStatus status;
        std::filesystem::path file;  // empty: built-in
        bool warm = false;           // somebody will ask for it first thing
        bool asked = false;          // in toLoad_, loading, or done
        int waiting = 0;             // clients in require()
    };
    void addBuiltins();
    std::string addFile(const std::filesystem::path& file);
    void addFolder(const std::filesystem::path& folder);
    void askFor(Entry& entry, bool first);
    Entry& entryFor(const std::string& id);
    void loadAll();
    void load(Entry& entry);
    void requireLight(Scene& scene) const;
    Scene made(Entry& entry);

    RenderQueue& queue_;
    ImportOptions import_;
    std::string defaultId_;
    std::map<std::string, std::shared_ptr<const EnvironmentMap>> environments_;  // from files

    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<std::unique_ptr<Entry>> entries_;  // in the order clients see; fixed once built
    std::deque<Entry*> toLoad_;
    bool ending_ = false;
    std::thread loader_;
};

}  // namespace clerestory
