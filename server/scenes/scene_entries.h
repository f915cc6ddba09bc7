// The table of all scenes: built-in ones, files, files of a folder, uploads. Not thread-safe; the
// library locks it. Ids are keys of this table and never parts of paths, except the ids of uploads,
// which UploadStore checks.
#pragma once

#include "renderer.h"
#include "scene/import/import.h"
#include "server/base/process.h"
#include "server/scenes/upload_store.h"

#include <deque>
#include <functional>
#include <memory>
#include <vector>

namespace clerestory {

struct UploadOptions {
    std::filesystem::path folder;  // empty: uploads are not allowed
    UploadLimits limits;
    // For uploaded files; the limit of their size is that of `limits`.
    ImportLimits import{.wallClock = std::chrono::milliseconds(10000),
                        .cpu = std::chrono::seconds(5),
                        .addressSpaceBytes = 1ull << 30,
                        .maxTriangles = 5'000'000,
                        .maxNodes = 10'000,
                        .maxImagePixels = 16'000'000,
                        .maxFiles = 256};
};

struct SceneSources {
    // Ids of built-in scenes, or files (SceneSource); the first is the default.
    std::vector<std::string> scenes;
    std::filesystem::path folder;  // files below it load when they are first requested
    std::vector<std::filesystem::path> environments;
    ImportOptions import;
    UploadOptions uploads;
    std::uint64_t memoryBytes = 2ull << 30;  // of loaded scenes; above it unused ones are evicted
};

// The source of the default scene.
std::string firstSourceOf(const SceneSources& sources);

// The memory of a loaded scene, on the renderer's side and on ours; with a software renderer both
// are main memory.
struct SceneBytes {
    // Vertices and indices on both sides; counted once if the driver reads ours without a copy.
    std::uint64_t meshes = 0;
    std::uint64_t textures = 0;  // with all mip levels
    std::uint64_t maps = 0;      // the most that captured cubes and ray tables of a frame took
    std::uint64_t total() const { return meshes + textures + maps; }
};
SceneBytes bytesOf(const Scene& scene);  // of a complete scene, with meshes on both sides

// Lights the scene with the built-in sky, and adds a warning that its own map is not loaded.
void lightWithSky(Scene& scene);

enum class SceneState { waiting, loading, ready, failed };
std::string_view nameOf(SceneState state);

// A scene of a file with several. The default scene has the id of the file, the others have a colon
// and their number after it.
struct SceneOfFile {
    std::string id, name;
};
using ScenesOfFile = std::vector<SceneOfFile>;

struct SceneStatus {
    std::string id, title;
    bool uploaded = false;
    SceneState state = SceneState::waiting;
    ImportProgress progress;
    std::string failure;                 // for users, when failed
    std::string reason;                  // its ImportError::Reason as a word
    std::shared_ptr<const Scene> scene;  // after the first loading; without vertices and texels
    std::size_t vertices = 0;
    SceneBytes bytes;  // while it is loaded
    // All scenes of its file, if that has several, in one list that they share; null before the
    // first loading of one.
    std::shared_ptr<const ScenesOfFile> scenesOfFile;
    // Of the frame with light of surfaces that was drawn last; see Frame::lightNow. May be empty.
    std::function<LightProgress()> lightNow;
};

struct SceneEntry {
    SceneStatus status;
    std::filesystem::path file;  // empty: built-in
    std::string sceneOfFile;     // as ImportOptions::scene
    std::string fileId;          // id of the entry of its file: its own, or that before the colon
    bool isRequested = false;    // waits to be loaded, is loading, or was loaded
    bool isSafe = false;         // another process has loaded it
    bool isDeleted = false;      // not found by id; removed when its last use ends
    int waiting = 0;             // calls that wait for it
    int users = 0;               // frames and others that use it
    std::uint64_t lastUsed = 0;  // counts the uses of all scenes
    // After a failure that is not the scene's own, such as lack of memory: when to try it again.
    Clock::time_point retryAt = Clock::time_point::max();
};

class SceneEntries {
public:
    using Entry = std::shared_ptr<SceneEntry>;

    // Throws std::runtime_error with a one-line message if a source does not exist.
    explicit SceneEntries(const SceneSources& sources);

    // In the order of GET /v1/scenes, without deleted ones.
    std::vector<Entry> listed() const;
    // Null if there is none, or it is deleted.
    Entry find(const std::string& id) const;
    // The entry of the file if the id has a colon and a number after it; null otherwise.
    Entry findFile(const std::string& id) const;
    // The scenes that the options name, or else the first built-in scene.
    const std::vector<Entry>& first() const { return first_; }

    // Adds entries for new uploads, also of other processes. uploads: UploadStore::all(). Returns
    // the entries whose uploads were removed.
    std::vector<Entry> updateUploads(const std::vector<Upload>& uploads);
    void remove(const Entry& entry);
    // Adds the other scenes of the entry's file after it. known: the entry's, loaded.
    void addScenesOfFile(const Entry& entry, const Scene& known);

private:
    Entry add(const std::string& id, const std::string& title, const std::filesystem::path& file);
    Entry addFile(const SceneSource& source);
    void addFolder(const std::filesystem::path& folder);
    static Entry makeOther(const SceneEntry& file, std::size_t number);

    std::vector<Entry> entries_, first_;
};

}  // namespace clerestory
