// Read access to the files below the scene file's folder, and to nothing else; and a scene and its
// files in a .zip or .tar archive, unpacked in memory, in the importing process: nothing in it can
// refer to a path on disk. Records every file that an importer looks for, so that a cached scene
// can be compared with the files of today.
//
// Does not: follow symbolic links, leave the folder by "..", open devices, pipes or folders.
#pragma once

#include "scene/import/base/types.h"

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace clerestory {

// A file that an import looked for, and what it found. Equal dependencies give equal scenes.
struct FileDependency {
    // present: exists, and was not read; overLimit: exists, and is too large to read.
    enum class State : std::uint8_t { absent, present, overLimit, read };

    std::string name;  // as requested, relative to the scene's folder
    State state = State::absent;
    std::uint64_t low = 0, high = 0;  // XXH3-128 of the content, when read

    bool operator==(const FileDependency&) const = default;
};

// Sets the state to `read`, and the hash to that of the content.
void setContent(FileDependency& dependency, std::string_view content);

class SceneFolder {
public:
    // maxBytes: of each file; all files together may have four times as many. Throws ImportError
    // (notFound) if the folder cannot be opened.
    SceneFolder(const std::filesystem::path& folder, std::uint64_t maxBytes,
                std::uint64_t maxFiles = ImportLimits{}.maxFiles);
    // Files in memory, by their path relative to the scene's folder.
    explicit SceneFolder(std::map<std::string, std::string> files);
    ~SceneFolder();
    SceneFolder(const SceneFolder&) = delete;
    SceneFolder& operator=(const SceneFolder&) = delete;

    // The whole content of a regular file. `name` is relative to the folder, with either slash.
    // Throws ImportError (notFound, limit), whose message contains `name`.
    std::string read(const std::string& name) const;

    bool has(const std::string& name) const;

    // Reads the file and returns its present state.
    FileDependency dependency(const std::string& name) const;

    // The results of all calls of has() and read() so far, sorted by name.
    std::vector<FileDependency> dependencies() const;

private:
    int open(const std::string& name) const;  // -1 if there is no readable regular file

    std::string readFrom(int file, const std::string& name) const;
    const std::string* inMemory(const std::string& name) const;  // null if there is none

    void record(const FileDependency& dependency) const;

    int folder_ = -1;  // -1: in memory
    const std::map<std::string, std::string> files_;
    std::uint64_t maxBytes_ = 0, maxFiles_ = 0;
    mutable std::atomic<std::uint64_t> bytesRead_{0};
    mutable std::atomic<std::uint64_t> filesRead_{0};
    mutable std::mutex mutex_;
    mutable std::map<std::string, FileDependency> dependencies_;
};

// "a%20b.png" -> "a b.png". A percent sign without two hexadecimal digits stays.
std::string percentDecoded(const std::string& uri);

bool isArchive(const std::string& extension);  // lower case, without the dot

struct UnpackedScene {
    std::string name;                          // of the scene file, relative to its folder
    std::map<std::string, std::string> files;  // in and below that folder, by relative path
};

// Finds the scene file with the fewest parent folders, glTF before other formats, and the files in
// and below its folder. Throws ImportError for links, devices, names that lead out of the archive,
// duplicate names, too many or too large files, and if there is no such scene file or several.
UnpackedScene unpackedScene(const std::string& archive, const ImportLimits& limits);

}  // namespace clerestory
