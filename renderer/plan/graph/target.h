// Description of a picture or cube that passes draw into and read.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace clerestory {

using TargetId = std::uint32_t;  // index of FramePlan::targets
inline constexpr TargetId kNoTarget = 0xffffffffu;

enum class TargetKind { plane, cube };
enum class Format { rgba16f, rgba32f, srgba8, rgba32ui, depth32f };
std::string_view nameOf(Format format);
// Where texels are: in textures of the driver, or in the program's memory. The latter is for planes
// that passes on the processor write: srgba8 by ToneMapping and EdgeFilter, floats by MeasureFlow
// and FollowLayer; nothing by CountLayer.
enum class Storage { driver, processor };

struct TargetSpec {
    std::string name;
    TargetKind kind = TargetKind::plane;
    Format format = Format::rgba16f;
    Storage storage = Storage::driver;
    std::uint32_t width = 0;  // texels; of a cube, of one face
    std::uint32_t height = 0;
    std::uint32_t levels = 1;
    bool depth = false;
    // A pass uses the part of it that it writes itself, so that any target is right that holds it.
    bool scratch = false;
    // One of another key may take its place: what it shows changes from frame to frame.
    bool replaceable = false;
    std::uint64_t residentKey = 0;  // not 0: the content outlives the frame and has this key
    // Not 0: a part of it follows the requested view and has this key. Passes redraw it in the
    // same target.
    std::uint64_t partKey = 0;
    // Hash of everything from which the planner derives residentKey: if it is equal, so is the key,
    // and the passes need not be planned to find it. 0: none.
    std::uint64_t inputsHash = 0;
    bool operator==(const TargetSpec&) const = default;
};

// A part of a target, in texels from its lower left corner.
struct TargetRect {
    std::uint32_t x = 0, y = 0, width = 0, height = 0;
    bool operator==(const TargetRect&) const = default;
};

// Number of texels of the given faces (of a cube) and levels.
enum class Faces { one, all };
enum class Levels { first, all };
std::uint64_t texelsOf(const TargetSpec& target, Faces faces, Levels levels);

}  // namespace clerestory
