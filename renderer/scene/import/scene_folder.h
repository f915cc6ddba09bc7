// The only door through which an importer reads files: what lies below the scene file's own folder.
//
// Does not: follow symbolic links, leave the folder by "..", open devices, pipes or folders.
#pragma once

#include "scene/import/file_reading.h"
#include "scene/import/import.h"

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <vector>

namespace clerestory {

class SceneFolder {
public:
    // maxBytes bounds each file; all files together may have four times as much. Throws
    // ImportError.
    SceneFolder(const std::filesystem::path& folder, std::uint64_t maxBytes,
                std::uint64_t maxFiles = ImportLimits{}.maxFiles);
    // Files that lie in memory, by their path relative to the folder that they would be in.
    explicit SceneFolder(std::map<std::string, std::string> files);
    ~SceneFolder();
    SceneFolder(const SceneFolder&) = delete;
    SceneFolder& operator=(const SceneFolder&) = delete;

    // A regular file's whole content. `name` is relative to the folder, with either slash. Throws
    // ImportError (notFound, limit), whose message names the file as it was asked for.
    std::string read(const std::string& name) const;

    bool has(const std::string& name) const;

    // What reading the file comes to, now.
    FileReading reading(const std::string& name) const;

    // What all calls of has() and read() so far were told, by name.
    std::vector<FileReading> readings() const;

private:
    int open(const std::string& name) const;  // -1 when there is none that may be read

    std::string readFrom(int file, const std::string& name) const;
    const std::string* inMemory(const std::string& name) const;  // null when there is none

    void note(const FileReading& reading) const;

    int folder_ = -1;  // -1: in memory
    const std::map<std::string, std::string> files_;
    std::uint64_t maxBytes_ = 0, maxFiles_ = 0;
    mutable std::atomic<std::uint64_t> bytesRead_{0};
    mutable std::atomic<std::uint64_t> filesRead_{0};
    mutable std::mutex mutex_;
    mutable std::map<std::string, FileReading> readings_;
};

// "a%20b.png" -> "a b.png"; a stray percent sign stays as it is.
std::string percentDecoded(const std::string& uri);

}  // namespace clerestory
