#include "passes/map_pictures.h"

#include <algorithm>
#include <set>

namespace clerestory {
namespace {

constexpr std::uint32_t kMaxPictureEdge = 256;

// The rows of `source` into `sheet` with its left upper corner at (x, y).
void place(const gl::Framebuffer& source, bool lowestFirst, Image& sheet, std::uint32_t x,
           std::uint32_t y) {
    std::vector<float> rgba(std::size_t{4} * source.width() * source.height());
    source.readFloats(rgba);
    for (std::uint32_t row = 0; row < source.height(); ++row) {
        const std::uint32_t from = lowestFirst ? source.height() - 1 - row : row;
        const float* in = rgba.data() + std::size_t{4} * source.width() * from;
        float* out = sheet.floats() + std::size_t{3} * (std::size_t{sheet.width} * (y + row) + x);
        for (std::uint32_t i = 0; i < source.width(); ++i, in += 4) {
            out = std::copy(in, in + 3, out);
        }
    }
}

Image sheetOf(const Target& cube) {
    std::uint32_t level = 0;
    while (level + 1 < cube.spec().levels && cube.spec().width >> level > kMaxPictureEdge) ++level;
    const std::uint32_t edge = cube.readable(0, level).width();
    Image sheet = makeImage(3 * edge, 2 * edge, 3, PixelType::float32);
    // A cube's first row is the top of its face as seen from within (OpenGL 4.3, table 8.18).
    for (std::uint32_t f = 0; f < 6; ++f) {
        place(cube.readable(f, level), false, sheet, f % 3 * edge, f / 3 * edge);
    }
    return sheet;
}

Image pictureOf(const Target& plane) {
    const gl::Framebuffer& source = plane.readable();
    Image picture = makeImage(source.width(), source.height(), 3, PixelType::float32);
    place(source, true, picture, 0, 0);
    return picture;
}

}  // namespace

std::vector<MapPicture> mapPictures(const FramePlan& plan, const std::vector<Target*>& targets) {
    std::set<TargetId> mirrored, seen;
    for (const Pass& pass : plan.passes) {
        if (pass.kind() == "mirror") mirrored.insert(pass.target);
    }
    std::vector<MapPicture> pictures;
    for (const Pass& pass : plan.passes) {
        const bool view = std::holds_alternative<DrawScene>(pass.work) ||
                          std::holds_alternative<DrawGlass>(pass.work);
        if (!view || pass.generation != 0) continue;
        for (const TargetId id : pass.reads()) {
            const Target& target = *targets[id];
            const bool cube = target.spec().kind == TargetKind::cube;
            if ((!cube && !mirrored.contains(id)) || !seen.insert(id).second) continue;
            pictures.push_back({plan.targets[id].name, cube ? sheetOf(target) : pictureOf(target)});
        }
    }
    return pictures;
}

}  // namespace clerestory
