// What an import has asked of the files in a scene's folder, and what it found: the same answers
// give the same scene.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace clerestory {

struct FileReading {
    // present: there, and not read; refused: there, and over a limit.
    enum class Outcome : std::uint8_t { absent, present, refused, read };

    std::string name;  // as it was asked for
    Outcome outcome = Outcome::absent;
    std::uint64_t low = 0, high = 0;  // XXH3-128 of the content, when read

    bool operator==(const FileReading&) const = default;
};

// The outcome is that it was read, and this is its content.
void setHash(FileReading& reading, std::string_view content);

}  // namespace clerestory
