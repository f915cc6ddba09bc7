// The files of scenes and environment maps that clients uploaded: one folder for each, named by the hash of its content.
// Reads only their first bytes. Several stores, also of several processes, can share a folder.
// Thread-safe.
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
    bool isMap = false;  // an environment map, not a scene
    // Why it could not be loaded: a message for users, and ImportError::Reason as a word; empty if
    // not known to fail.
    std::string failure, reason;
};

class UploadStore {
public:
    // Creates the folder, accessible to its owner only. Throws std::runtime_error with one line.
    UploadStore(std::filesystem::path folder, const UploadLimits& limits);

    // The type by the content: an extension of a scene, an archive or an environment map without
    // its dot ("glb"), empty if it is none of them. A .obj has no mark; it is read from archives.
    static std::string kindOf(std::string_view content);
    static bool isMapKind(std::string_view kind);
    // Equal content has an equal id; a collision cannot be constructed (SHA-256).
    static std::string idOf(std::string_view content);
    static bool isId(std::string_view text);

    std::optional<Upload> find(const std::string& id) const;
    std::vector<Upload> all() const;  // by id

    // Atomic; written to disk when this returns. `kind` is a result of kindOf(). Throws
    // RequestError 507 if a limit is reached or the disk is full.
    Upload add(const std::string& kind, const std::string& title, std::string_view content);
    // Returns whether it existed.
    bool remove(const std::string& id);
    // Visible to all stores of the folder. An empty message clears the failure.
    void setFailure(const std::string& id, const std::string& message, const std::string& reason);

    // Call before and after each attempt to load it. beginLoading() returns the number of earlier
    // attempts without an end: their processes ended.
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
