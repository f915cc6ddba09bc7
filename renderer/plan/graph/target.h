// What passes draw into and read: a picture or a cube of a size and format.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace clerestory {

using TargetId = std::uint32_t;  // into FramePlan::targets
inline constexpr TargetId kNoTarget = 0xffffffffu;

enum class TargetKind { plane, cube };
enum class Format { rgba16f, rgba32f, srgba8 };
std::string_view nameOf(Format format);

struct TargetSpec {
    std::string name;
    TargetKind kind = TargetKind::plane;
    Format format = Format::rgba16f;
    std::uint32_t width = 0;  // texels; of a cube, of one face
    std::uint32_t height = 0;
    std::uint32_t levels = 1;
    std::uint32_t samples = 1;
    bool depth = false;
    std::uint64_t residentKey = 0;  // not 0: its content outlives the frame under this key
    // Hash of everything the planner looked at to find that key: where it is the same, so is the
    // key, and nothing has to be planned to know it.
    std::uint64_t circumstances = 0;
    bool operator==(const TargetSpec&) const = default;
};

// Texels of the target, or of its first level alone, over all faces of a cube or one of them.
enum class Faces { one, all };
enum class Levels { first, all };
std::uint64_t texelsOf(const TargetSpec& target, Faces faces, Levels levels);

}  // namespace clerestory
