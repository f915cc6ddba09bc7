#include "plan/graph/target.h"

#include <algorithm>

namespace clerestory {

std::string_view nameOf(Format format) {
    switch (format) {
        case Format::rgba16f:
            return "rgba16f";
        case Format::rgba32f:
            return "rgba32f";
        case Format::srgba8:
            return "srgba8";
        case Format::rgba32ui:
            return "rgba32ui";
        case Format::depth32f:
            return "depth32f";
    }
    return "";
}

std::uint64_t texelsOf(const TargetSpec& target, Faces faces, Levels levels) {
    std::uint64_t texels = 0;
    for (std::uint32_t level = 0; level < (levels == Levels::all ? target.levels : 1); ++level) {
        texels += std::uint64_t{std::max(1u, target.width >> level)} *
                  std::max(1u, target.height >> level);
    }
    return faces == Faces::all ? 6 * texels : texels;
}

}  // namespace clerestory
