#include "plan/warm_up.h"

#include "plan/graph/features.h"
#include "plan/graph/view_bits.h"

#include <algorithm>
#include <bit>
#include <set>
#include <tuple>

namespace clerestory {
namespace {

// llvmpipe compiles different code for edges that are powers of two.
std::uint32_t smallEdge(std::uint32_t edge) {
    return std::has_single_bit(edge) ? std::min(edge, 8u) : std::min(edge, 12u);
}

TargetSpec smallTarget(TargetSpec spec) {
    spec.width = smallEdge(spec.width);
    spec.height = smallEdge(spec.height);
    const auto maxLevels =
        static_cast<std::uint32_t>(std::bit_width(std::max(spec.width, spec.height)));
    spec.levels = std::min(spec.levels, maxLevels);
    spec.residentKey = spec.partKey = spec.inputsHash = 0;
    return spec;
}

}  // namespace

enum class DrawStage { depth, opaque, recorded, blended };

// What the plans so far contain.
struct WarmUpPrograms {
    using ViewBits = std::uint32_t;
    std::set<std::tuple<std::string_view, TargetKind, Format>> fullScreen;
    // bool: whether it reflects a picture.
    std::set<
        std::tuple<std::string_view, DrawStage, ViewBits, Features, Index, bool, Format, Primitive>>
        draws;
    std::set<Format> rays;
    std::set<std::uint64_t> maps;  // by resident key
    std::set<ViewBits> skies;
};

namespace {

class WarmUpPasses {
public:
    WarmUpPasses(const FramePlan& plan, WarmUpPrograms& planned) : plan_(plan), planned_(planned) {}

    std::vector<Pass> all() {
        for (const Pass& pass : plan_.passes) {
            std::visit([&](const auto& work) { add(pass, work); }, pass.work);
        }
        passes_.insert(passes_.end(), last_.begin(), last_.end());
        return std::move(passes_);
    }

private:
    void add(const Pass& pass, const PrefilterMap&) {
        if (planned_.maps.insert(plan_.targets[pass.target].residentKey).second) {
            passes_.push_back(pass);
        }
    }

    // It has no programs.
    void add(const Pass&, const EmitterCoverage&) {}

    // A full-screen pass.
    template <class Work>
    void add(const Pass& pass, const Work&) {
        const TargetSpec& target = plan_.targets[pass.target];
        if (planned_.fullScreen.emplace(pass.kind(), target.kind, target.format).second) {
            passes_.push_back(pass);
        }
    }

    // Executes again what has programs of its own for chosen pixels, in all pixels.
    void add(const Pass& pass, const Supersampling& work) {
        const TargetSpec& target = plan_.targets[pass.target];
        if (!planned_.fullScreen.emplace(pass.kind(), target.kind, target.format).second) return;
        Supersampling bare = work;
        bare.passes.clear();
        bare.samples = bare.firstSamples = 2;
        bare.share = 1.0;
        bare.leastContrast = 0.0;
        for (const auto& [again, part] : work.passes) {
            Pass repeated = plan_.passes[again];
            if (const auto* scene = std::get_if<DrawScene>(&repeated.work)) {
                repeated.work = DrawScene{.view = scene->view};
            } else if (!std::holds_alternative<CopyBackdrop>(repeated.work)) {
                continue;
            }
            bare.passes.push_back({passes_.size(), part});
            passes_.push_back(std::move(repeated));
        }
        passes_.push_back(pass);
        passes_.back().work = std::move(bare);
    }

    // Last: it waits for the hierarchy of the scene, which another thread builds from the first
    // record of rays on.
    void add(const Pass& pass, const FollowRays& work) {
        const TargetSpec& target = plan_.targets[pass.target];
        if (!planned_.rays.insert(target.format).second) return;
        FollowRays bare = work;
        bare.rect = {0, 0, 1, 1};
        last_.push_back(pass);
        last_.back().work = std::move(bare);
    }

    void add(const Pass& pass, const DrawScene& work) {
        DrawScene bare = work;
        bare.depthDraws = bare.opaqueDraws = bare.recorded.draws = bare.blendedDraws = {};
        bare.sky = false;
        if (work.sky && planned_.skies.insert(bitsOf(work.view)).second) {
            passes_.push_back(pass);
            passes_.back().work = bare;
            std::get<DrawScene>(passes_.back().work).sky = true;
        }
        for (const Draw& draw : work.opaqueDraws) {
            // A view from closer by may have a depth prepass when this one has none.
            if (!(draw.features & FEATURE_MASK) && draw.primitive == Primitive::triangles) {
                Draw depth = draw;
                depth.features &= FEATURE_DOUBLE_SIDED;
                add(pass, bare, &DrawScene::depthDraws, depth, DrawStage::depth);
            }
            add(pass, bare, &DrawScene::opaqueDraws, draw, DrawStage::opaque);
        }
        for (const Draw& draw : work.recorded.draws) addRecorded(pass, bare, draw);
        for (const Draw& draw : work.blendedDraws) {
            add(pass, bare, &DrawScene::blendedDraws, draw, DrawStage::blended);
        }
    }

    void add(const Pass& pass, const DrawGlass& work) {
        DrawGlass bare = work;
        bare.glassDraws = bare.recorded.draws = bare.blendedDraws = {};
        for (const Draw& draw : work.glassDraws) {
            add(pass, bare, &DrawGlass::glassDraws, draw, DrawStage::opaque);
        }
        for (const Draw& draw : work.recorded.draws) addRecorded(pass, bare, draw);
        for (const Draw& draw : work.blendedDraws) {
            add(pass, bare, &DrawGlass::blendedDraws, draw, DrawStage::blended);
        }
    }

    void add(const Pass& pass, const DrawBlended& work) {
        DrawBlended bare = work;
        bare.draws = bare.recorded.draws = {};
        for (const Draw& draw : work.draws) {
            add(pass, bare, &DrawBlended::draws, draw, DrawStage::blended);
        }
        for (const Draw& draw : work.recorded.draws) addRecorded(pass, bare, draw);
    }

    void add(const Pass& pass, const DrawShadow& work) {
        for (const Draw& draw : work.draws) {
            add(pass, DrawShadow{.view = work.view, .tile = work.tile}, &DrawShadow::draws, draw,
                DrawStage::opaque);
        }
    }

    void add(const Pass& pass, const DrawShadowTint& work) {
        for (const Draw& draw : work.draws) {
            add(pass, DrawShadowTint{.view = work.view, .tile = work.tile}, &DrawShadowTint::draws,
                draw, DrawStage::opaque);
        }
    }

    void add(const Pass& pass, const DrawBackFaces& work) {
        for (const Draw& draw : work.draws) {
            add(pass, DrawBackFaces{.view = work.view}, &DrawBackFaces::draws, draw,
                DrawStage::opaque);
        }
    }

    void add(const Pass& pass, const DrawChannel& work) {
        for (const Draw& draw : work.draws) {
            add(pass, DrawChannel{.view = work.view}, &DrawChannel::draws, draw, DrawStage::opaque);
        }
    }

    // Adds a draw whose program is new: to the last pass if that has the same type and program,
    // otherwise to a new pass made from `bare`.
    template <class Work>
    void add(const Pass& pass, const Work& bare, std::vector<Draw> Work::*list, const Draw& draw,
             DrawStage stage) {
        addTo(
            pass, bare, draw, stage, [list](auto& work) -> auto& { return work.*list; });
    }
    template <class Work>
    void addRecorded(const Pass& pass, const Work& bare, const Draw& draw) {
        addTo(
            pass, bare, draw, DrawStage::recorded,
            [](auto& work) -> auto& { return work.recorded.draws; });
    }
    template <class Work, class List>
    void addTo(const Pass& pass, const Work& bare, const Draw& draw, DrawStage stage, List list) {
        const TargetSpec& target = plan_.targets[pass.target];
        const bool isNew =
            planned_.draws
                .emplace(pass.kind(), stage, bitsOf(bare.view), draw.features,
                         stage == DrawStage::depth ? kNone : draw.material,
                         draw.reflection != kNoReflection, target.format, draw.primitive)
                .second;
        if (!isNew) return;
        const auto holds = [&](const Pass& last) {
            const auto* work = std::get_if<Work>(&last.work);
            return last.name == pass.name && last.target == pass.target && work &&
                   work->view == bare.view && !list(*work).empty() &&
                   list(*work).front().features == draw.features;
        };
        if (passes_.empty() || !holds(passes_.back())) {
            passes_.push_back(pass);
            passes_.back().work = bare;
        }
        list(std::get<Work>(passes_.back().work)).push_back(draw);
    }

    std::uint32_t bitsOf(const View& view) const {
        return viewBits(plan_, view, plan_.transparent, plan_.surfaceLight != 0);
    }

    const FramePlan& plan_;
    WarmUpPrograms& planned_;
    std::vector<Pass> passes_, last_;
};

}  // namespace

WarmUpPlanner::WarmUpPlanner() : planned_(std::make_unique<WarmUpPrograms>()) {}
WarmUpPlanner::~WarmUpPlanner() = default;

FramePlan WarmUpPlanner::plan(const FramePlan& plan) {
    FramePlan warm = plan;
    warm.passes = WarmUpPasses(plan, *planned_).all();
    std::set<TargetId> whole;
    for (const Pass& pass : warm.passes) {
        if (std::holds_alternative<PrefilterMap>(pass.work)) whole.insert(pass.target);
    }
    for (TargetId id = 0; id < warm.targets.size(); ++id) {
        if (!whole.contains(id)) warm.targets[id] = smallTarget(std::move(warm.targets[id]));
    }
    return warm;
}

}  // namespace clerestory
