#include "passes/health.h"

#include <algorithm>
#include <cmath>

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

// Normals are directions, and stand where colour stands elsewhere.
bool holdsLight(const FramePlan& plan, TargetId target) {
    return std::none_of(plan.passes.begin(), plan.passes.end(), [&](const Pass& pass) {
        return pass.target == target && (std::holds_alternative<DrawBackFaces>(pass.work) ||
                                         std::holds_alternative<DrawChannel>(pass.work));
    });
}

}  // namespace

std::vector<TexelCounts> examined(const FramePlan& plan, const std::vector<Target*>& targets) {
    std::vector<TexelCounts> result(targets.size());
    for (std::size_t i = 0; i < targets.size(); ++i) {
        const TargetSpec& spec = targets[i]->spec();
        if (spec.format == Format::srgba8) continue;
        const bool light = holdsLight(plan, static_cast<TargetId>(i));
        for (std::uint32_t level = 0; level < spec.levels; ++level) {
            for (std::uint32_t f = 0; f < (spec.kind == TargetKind::cube ? 6u : 1u); ++f) {
                count(targets[i]->readable(f, level), light, result[i]);
            }
        }
    }
    return result;
}

}  // namespace clerestory
