// The only door through which an importer reads files: what lies below the scene file's own folder.
//
// Does not: follow symbolic links, leave the folder by "..", open devices, pipes or folders.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>

namespace clerestory {

class SceneFolder {
public:
    // maxBytes bounds each file; all files together may have four times as much. Throws
    // ImportError.
    SceneFolder(const std::filesystem::path& folder, std::uint64_t maxBytes);
    ~SceneFolder();
    SceneFolder(const SceneFolder&) = delete;
    SceneFolder& operator=(const SceneFolder&) = delete;

    // A regular file's whole content. `name` is relative to the folder, with either slash. Throws
    // ImportError (notFound, limit), whose message names the file as it was asked for.
    std::string read(const std::string& name) const;

    bool has(const std::string& name) const;

private:
    int open(const std::string& name) const;  // -1 when there is none that may be read

    int folder_ = -1;
    std::uint64_t maxBytes_;
    mutable std::atomic<std::uint64_t> bytesRead_{0};
    mutable std::atomic<std::uint32_t> filesRead_{0};
};

// "a%20b.png" -> "a b.png"; a stray percent sign stays as it is.
std::string percentDecoded(const std::string& uri);

}  // namespace clerestory
