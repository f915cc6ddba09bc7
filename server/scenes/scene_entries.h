// The table of the scenes that there are: built-in ones, files, files of a folder, uploads. Who may
// change it when is the library's business. Ids are keys of the table; they never become paths,
// except that an upload's is looked for among the uploads.
#pragma once

#include "scene/import/import.h"
#include "server/base/clock.h"
#include "server/scenes/upload_store.h"

#include <deque>
#include <memory>
#include <vector>

namespace clerestory {

struct UploadOptions {
    std::filesystem::path folder;  // empty: nobody may upload
    UploadLimits limits;
    // Of the files of others; their bytes are those of `limits`.
    ImportLimits import{.wallClock = std::chrono::milliseconds(10000),
                        .cpu = std::chrono::seconds(5),
                        .addressSpaceBytes = 1ull << 30,
                        .maxTriangles = 5'000'000,
                        .maxNodes = 10'000,
                        .maxImagePixels = 16'000'000,
                        .maxFiles = 256};
};

struct SceneSources {
    std::vector<std::string> scenes;  // ids of built-in scenes, or files; the first is the default
    std::filesystem::path folder;     // files found below it load when first asked for
    std::vector<std::filesystem::path> environments;
    ImportOptions import;
    UploadOptions uploads;
    std::uint64_t memoryBytes = 2ull << 30;  // of loaded scenes; above it unused ones are let go
};

// The text that names the scene loaded first.
std::string firstSourceOf(const SceneSources& sources);

// What a loaded scene takes; on a software renderer the processor's memory holds both sides.
struct SceneBytes {
    // Vertices and indices, here and on the renderer's side: once where the driver reads them where
    // they lie.
    std::uint64_t meshes = 0;
    std::uint64_t textures = 0;  // with their smaller levels
    std::uint64_t maps = 0;      // most that a frame's captured cubes and tables for rays took
    std::uint64_t total() const { return meshes + textures + maps; }
};
SceneBytes bytesOf(const Scene& scene);  // of a whole scene, as if nothing were held once

enum class SceneState { waiting, loading, ready, failed };
std::string_view nameOf(SceneState state);

struct SceneStatus {
    std::string id, title;
    bool uploaded = false;
    SceneState state = SceneState::waiting;
    ImportProgress progress;
    std::string failure;                 // words for people, when failed
    std::string reason;                  // of it; a word of reasonOf()
    std::shared_ptr<const Scene> scene;  // once it was loaded; without vertices, indices and texels
    std::size_t vertices = 0;
    SceneBytes bytes;  // while it is loaded
};

struct SceneEntry {
    SceneStatus status;
    std::filesystem::path file;  // empty: built-in
    bool warm = false;           // somebody will ask for it first thing
    bool asked = false;          // waits to be loaded, loading, or done
    bool harmless = false;       // another process holds it
    bool deleted = false;        // nobody finds it; it goes when its last user has
    int waiting = 0;             // clients that wait for it
    int users = 0;               // frames and the like that rely on it
    std::uint64_t lastUsed = 0;  // counts uses of all scenes
    // When it may be tried anew after a failure that was not the scene's own, such as no memory.
    Clock::time_point again = Clock::time_point::max();
};

class SceneEntries {
public:
    using Entry = std::shared_ptr<SceneEntry>;

    // Throws std::runtime_error with one line about a source that is not there.
    explicit SceneEntries(const SceneSources& sources);

    // In the order clients see; deleted ones are left out.
    std::vector<Entry> listed() const;
    // Null when there is none, or no longer.
    Entry find(const std::string& id) const;
    // Those that were named, or the first there is.
    const std::vector<Entry>& first() const { return first_; }

    // Uploads that others have added or removed come and go here. Returns those that went.
    std::vector<Entry> followUploads(const UploadStore& uploads);
    void drop(const Entry& entry);

private:
    Entry add(const std::string& id, const std::string& title, const std::filesystem::path& file);
    Entry addFile(const std::filesystem::path& file);
    void addFolder(const std::filesystem::path& folder);

    std::vector<Entry> entries_, first_;
};

}  // namespace clerestory
