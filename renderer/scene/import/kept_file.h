// Files that the program keeps for itself from one start to the next. Any number of processes may
// share a folder: a file appears whole or not at all, and what a power cut leaves of one must be
// told by its own checksum.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>

namespace clerestory {

// In memory and not mapped: a mapping of a disk that fails ends the process.
struct KeptContent {
    std::unique_ptr<std::byte[]> bytes;
    std::size_t size = 0;
    std::span<const std::byte> span() const { return {bytes.get(), size}; }
};

// Nothing for what is not there, is not a plain file of this user's, or has more than `most` bytes.
// The file counts as used now. Throws std::bad_alloc.
std::optional<KeptContent> readKept(const std::filesystem::path& file, std::uint64_t most);

// The parts one after another; the folder is made, for its owner alone. False with errno when it
// cannot be kept.
bool writeKept(const std::filesystem::path& file,
               std::initializer_list<std::span<const std::byte>> parts);

// Removes files with this extension, those used longest ago first, until the others have at most
// `mostBytes`; and what writers that ended have left.
void sweepKept(const std::filesystem::path& folder, const char* extension, std::uint64_t mostBytes);

}  // namespace clerestory
