#include "passes/readback.h"

#include "passes/targets.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace clerestory {
namespace {

void count(const gl::Framebuffer& picture, bool light, TexelCounts& counts) {
    const std::size_t texels = std::size_t{picture.width()} * picture.height();
    std::vector<float> rgba(4 * texels);
    picture.readFloats(rgba);
    counts.texels += texels;
    for (auto texel = rgba.begin(); texel != rgba.end(); texel += 4) {
        const bool finite = std::all_of(texel, texel + 4, [](float x) { return std::isfinite(x); });
        counts.nonFinite += !finite;
        counts.negative +=
            finite && light && std::any_of(texel, texel + 4, [](float x) { return x < 0.0f; });
    }
}

void countDepths(const gl::Framebuffer& picture, TexelCounts& counts) {
    std::vector<float> depths(std::size_t{picture.width()} * picture.height());
    picture.readDepths(depths);
    counts.texels += depths.size();
    for (const float depth : depths) counts.nonFinite += !std::isfinite(depth);
}

// False for targets whose channels hold normals or identifiers.
bool holdsLight(const FramePlan& plan, TargetId target) {
    return std::none_of(plan.passes.begin(), plan.passes.end(), [&](const Pass& pass) {
        return pass.target == target && (std::holds_alternative<DrawBackFaces>(pass.work) ||
                                         std::holds_alternative<DrawChannel>(pass.work));
    });
}

constexpr std::uint32_t kMaxPictureEdge = 256;

// Copies `source` into `sheet` with its upper left corner at (x, y).
void copyInto(const gl::Framebuffer& source, bool bottomFirst, Image& sheet, std::uint32_t x,
              std::uint32_t y) {
    std::vector<float> rgba(std::size_t{4} * source.width() * source.height());
    source.readFloats(rgba);
    for (std::uint32_t row = 0; row < source.height(); ++row) {
        const std::uint32_t from = bottomFirst ? source.height() - 1 - row : row;
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
    // The first row of a face is its top, seen from inside the cube (OpenGL 4.3, table 8.18).
    for (std::uint32_t f = 0; f < 6; ++f) {
        copyInto(cube.readable(f, level), false, sheet, f % 3 * edge, f / 3 * edge);
    }
    return sheet;
}

Image pictureOf(const Target& plane) {
    const gl::Framebuffer& source = plane.readable();
    Image picture = makeImage(source.width(), source.height(), 3, PixelType::float32);
    copyInto(source, true, picture, 0, 0);
    return picture;
}

}  // namespace

std::vector<TexelCounts> countInvalidTexels(const FramePlan& plan,
                                            const std::vector<Target*>& targets) {
    std::vector<TexelCounts> result(targets.size());
    for (std::size_t i = 0; i < targets.size(); ++i) {
        const TargetSpec& spec = targets[i]->spec();
        if (spec.storage == Storage::processor || spec.format == Format::srgba8 ||
            spec.format == Format::rgba32ui)
            continue;
        if (spec.format == Format::depth32f) {
            countDepths(targets[i]->readable(), result[i]);
            continue;
        }
        const bool light = holdsLight(plan, static_cast<TargetId>(i));
        for (std::uint32_t level = 0; level < spec.levels; ++level) {
            for (std::uint32_t f = 0; f < (spec.kind == TargetKind::cube ? 6u : 1u); ++f) {
                count(targets[i]->readable(f, level), light, result[i]);
            }
        }
    }
    return result;
}

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
