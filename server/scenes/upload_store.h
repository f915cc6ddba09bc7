// Scenes that clients sent, as they were sent: one folder for each, named by what it holds. Nothing
// in them is looked into here but the first bytes. Any number of stores may share a folder, also in
// several processes. Thread-safe.
#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace clerestory {

struct UploadLimits {
    std::size_t fileBytes = 64 << 20;   // of one upload
    std::size_t count = 64;             // kept at once
    std::uint64_t keptBytes = 1 << 30;  // of all of them
};

struct Upload {
    std::string id, title;
    std::filesystem::path file;
    std::uint64_t bytes = 0;
    // Why it gave no scene: in words for people, and a word of reasonOf(); empty: not known to
    // fail.
    std::string failure, reason;
};

class UploadStore {
public:
    // Makes the folder, for its owner alone. Throws std::runtime_error with one line.
    UploadStore(std::filesystem::path folder, const UploadLimits& limits);

    // What a file is, by its first bytes: "glb", "gltf", "zip", "tar", "tgz"; empty: none of these.
    static std::string kindOf(std::string_view content);
    // The same content has the same id, and nobody can make another of that id.
    static std::string idOf(std::string_view content);

    std::optional<Upload> find(const std::string& id) const;
    std::vector<Upload> all() const;  // by id

    // Whole and on the disk when this returns, or not there. `kind` is of kindOf(). Throws
    // RequestError 507 when there is no room, here or on the disk.
    Upload add(const std::string& kind, const std::string& title, std::string_view content);
    // Whether it was there.
    bool remove(const std::string& id);
    // Remembered by all who share the folder; empty words take it back.
    void setFailure(const std::string& id, const std::string& words, const std::string& reason);

    // Round every attempt to load it. Returns how many before this one have not come to an end:
    // whoever made them ended.
    std::uint64_t beginLoading(const std::string& id);
    void endLoading(const std::string& id);

private:
    std::optional<Upload> read(const std::filesystem::path& place) const;
    void requireRoom(std::size_t bytes) const;

    const std::filesystem::path folder_;
    const UploadLimits limits_;
    std::mutex adding_;
};

}  // namespace clerestory
