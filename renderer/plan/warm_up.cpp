#include "plan/warm_up.h"

#include "plan/features.h"

#include <algorithm>
#include <bit>
#include <set>
#include <tuple>

namespace clerestory {
namespace {

// Whether an edge is a power of two is part of what llvmpipe compiles for.
std::uint32_t smallEdge(std::uint32_t edge) {
    return std::has_single_bit(edge) ? std::min(edge, 8u) : std::min(edge, 12u);
}

TargetSpec smallTarget(TargetSpec spec) {
    spec.width = smallEdge(spec.width);
    spec.height = smallEdge(spec.height);
    const auto most = static_cast<std::uint32_t>(std::bit_width(std::max(spec.width, spec.height)));
    spec.levels = std::min(spec.levels, most);
    spec.residentKey = spec.circumstances = 0;
    return spec;
}

enum class Stage { depth, opaque, blended };

class WarmUpPasses {
public:
    explicit WarmUpPasses(const FramePlan& plan) : plan_(plan) {}

    std::vector<Pass> all() {
        for (const Pass& pass : plan_.passes) {
            if (pass.views.empty()) {
                addFullScreen(pass);
            } else {
                addDraws(pass);
            }
        }
        return std::move(passes_);
    }

private:
    void addFullScreen(const Pass& pass) {
        const TargetSpec& target = plan_.targets[pass.target];
        if (pass.kind == PassKind::environment) {
            passes_.push_back(pass);
        } else if (seenFullScreen_.emplace(pass.kind, target.kind, target.format).second) {
            passes_.push_back(pass);
        }
    }

    void addDraws(const Pass& pass) {
        Pass bare = pass;
        bare.depthDraws.clear();
        bare.opaqueDraws.clear();
        bare.blendedDraws.clear();
        bare.sky = false;
        if (pass.sky && !seenSky_) {
            seenSky_ = true;
            passes_.push_back(bare);
            passes_.back().sky = true;
        }
        // A nearer view may draw depth first where this one does not.
        const bool depthFirst = pass.kind != PassKind::glass && pass.kind != PassKind::backFaces &&
                                pass.kind != PassKind::channel;
        for (const Draw& draw : pass.opaqueDraws) {
            if (depthFirst && !(draw.features & FEATURE_MASK)) {
                Draw depth = draw;
                depth.features &= FEATURE_DOUBLE_SIDED;
                add(bare, depth, Stage::depth);
            }
            add(bare, draw, Stage::opaque);
        }
        for (const Draw& draw : pass.blendedDraws) add(bare, draw, Stage::blended);
    }

    void add(const Pass& bare, const Draw& draw, Stage stage) {
        const TargetSpec& target = plan_.targets[bare.target];
        const auto key = std::tuple(bare.kind, stage, draw.features,
                                    stage == Stage::depth ? kNone : draw.material,
                                    draw.reflection == kNoReflection, target.format, target.samples,
                                    bare.views.front().orthographic);
        if (!seenDraws_.insert(key).second) return;
        if (passes_.empty() || !holds(passes_.back(), bare, draw, stage)) passes_.push_back(bare);
        drawsOf(passes_.back(), stage).push_back(draw);
    }

    static std::vector<Draw>& drawsOf(Pass& pass, Stage stage) {
        return stage == Stage::depth    ? pass.depthDraws
               : stage == Stage::opaque ? pass.opaqueDraws
                                        : pass.blendedDraws;
    }

    // Whether the draw uses the program that this pass has.
    static bool holds(Pass& pass, const Pass& bare, const Draw& draw, Stage stage) {
        const std::vector<Draw>& draws = drawsOf(pass, stage);
        return pass.name == bare.name && pass.target == bare.target && pass.face == bare.face &&
               !draws.empty() && draws.front().features == draw.features;
    }

    const FramePlan& plan_;
    std::vector<Pass> passes_;
    std::set<std::tuple<PassKind, TargetKind, Format>> seenFullScreen_;
    std::set<std::tuple<PassKind, Stage, Features, Index, bool, Format, std::uint32_t, bool>>
        seenDraws_;
    bool seenSky_ = false;
};

}  // namespace

FramePlan warmUpPlan(const FramePlan& plan) {
    FramePlan warm = plan;
    warm.passes = WarmUpPasses(plan).all();
    std::set<TargetId> whole;
    for (const Pass& pass : warm.passes) {
        if (pass.kind == PassKind::environment) whole.insert(pass.target);
    }
    for (TargetId id = 0; id < warm.targets.size(); ++id) {
        if (!whole.contains(id)) warm.targets[id] = smallTarget(std::move(warm.targets[id]));
    }
    return warm;
}

}  // namespace clerestory
