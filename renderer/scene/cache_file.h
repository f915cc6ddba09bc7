// Files of what was computed before, so that a restart does not compute it again.
//
//     writeCacheFile(folder / "name.light", {header, values});
//     trimCacheFolder(folder, ".light", 1ull << 30);
//     if (const auto content = readCacheFile(folder / "name.light", 1ull << 30))
//     use(content->span());
//
// Several processes may share a folder: a file appears complete or not at all. After a power
// failure a file may be damaged, so its content needs a checksum.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>

namespace clerestory {

// A file that is read from its beginning to its end. It is not mapped: a failing disk under a
// mapping would end the process.
class CacheReader {
public:
    // Nothing if the file does not exist, is not a regular file of this user, or has more than
    // `maxBytes`. Sets the file's time of last use.
    static std::optional<CacheReader> open(const std::filesystem::path& file,
                                           std::uint64_t maxBytes);
    CacheReader(CacheReader&& from) noexcept;
    ~CacheReader();

    std::uint64_t left() const { return left_; }
    // Copies the next bytes to `to`. Returns false if the file cannot be read or ends before.
    bool read(void* to, std::size_t count);

private:
    CacheReader(int file, std::uint64_t left) : file_(file), left_(left) {}

    int file_;  // -1: none
    std::uint64_t left_;
};

struct CacheContent {
    std::unique_ptr<std::byte[]> bytes;
    std::size_t size = 0;
    std::span<const std::byte> span() const { return {bytes.get(), size}; }
};

// The whole of a file that CacheReader can open and read. Throws std::bad_alloc.
std::optional<CacheContent> readCacheFile(const std::filesystem::path& file,
                                          std::uint64_t maxBytes);

// Writes the parts one after another. Creates the folder, accessible to its owner alone. Returns
// false, with errno set, on failure.
bool writeCacheFile(const std::filesystem::path& file,
                    std::initializer_list<std::span<const std::byte>> parts);

// Removes the least recently used files with this extension until the others have at most
// `maxBytes` together, and incomplete files that are older than an hour.
void trimCacheFolder(const std::filesystem::path& folder, const char* extension,
                     std::uint64_t maxBytes);

}  // namespace clerestory
