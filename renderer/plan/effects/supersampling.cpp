#include "plan/effects/supersampling.h"

#include <algorithm>
#include <map>

namespace clerestory {
namespace {

// See docs/architecture/supersampling.md.
constexpr double kLeastContrast = 0.15;
constexpr std::uint32_t kFirstSamples = 4;
constexpr double kLeastDifference = 0.2;

std::span<const ReflectedPicture> reflectionsOf(const Pass& pass) {
    return std::visit(
        [](const auto& work) -> std::span<const ReflectedPicture> {
            if constexpr (requires { work.reflections; }) return work.reflections;
            return {};
        },
        pass.work);
}

// Adds to the work the passes from `firstPass` on that draw the picture in `target`: not those of
// maps, which do not depend on where a view has its samples.
class RepeatedPasses {
public:
    RepeatedPasses(PlanBuilder& builder, Supersampling& work) : builder_(builder), work_(work) {}

    void add(std::size_t firstPass, TargetId target) {
        const FramePlan& plan = builder_.plan();
        places_[target] = {};
        for (std::size_t i = plan.passes.size();
             i-- > firstPass;) {  // readers before what they read
            // A sample is a point; the first one is a mean already where emitters are small.
            if (std::holds_alternative<EmitterCoverage>(plan.passes[i].work)) continue;
            const auto found = places_.find(plan.passes[i].target);
            if (found == places_.end()) continue;
            const Place place = found->second;
            work_.passes.push_back({i, partAt(place, plan.passes[i].target)});
            for (const ReflectedPicture& r : reflectionsOf(plan.passes[i])) {
                addPicture(r.target,
                           {place.origin + r.origin / place.scale, place.scale * r.scale});
            }
            for (const TargetId id : builder_.plan().passes[i].reads()) addPicture(id, place);
        }
        std::reverse(work_.passes.begin(), work_.passes.end());
    }

private:
    struct Place {
        glm::dvec2 origin{0.0};
        double scale = 1.0;
    };

    void addPicture(TargetId id, const Place& place) {
        if (id == kNoTarget) return;
        const TargetSpec& spec = builder_.target(id);
        if (spec.kind == TargetKind::plane && spec.residentKey == 0) places_.emplace(id, place);
    }

    std::size_t partAt(const Place& place, TargetId target) {
        const TargetSpec spec = builder_.target(target);
        for (std::size_t part = 0; part < work_.parts.size(); ++part) {
            const auto& [origin, scale, chosen] = work_.parts[part];
            const TargetSpec& other = builder_.target(chosen);
            if (origin == place.origin && scale == place.scale && other.width == spec.width &&
                other.height == spec.height) {
                return part;
            }
        }
        work_.parts.push_back({place.origin, place.scale,
                               builder_.addTarget({.name = "chosenPixels",
                                                   .format = Format::depth32f,
                                                   .width = spec.width,
                                                   .height = spec.height})});
        return work_.parts.size() - 1;
    }

    PlanBuilder& builder_;
    Supersampling& work_;
    std::map<TargetId, Place> places_;
};

}  // namespace

void planSupersampling(PlanBuilder& builder, std::size_t firstPass, TargetId target,
                       const FrameRequest& request, float exposureFactor) {
    if (request.accuracy.samples < 2) return;
    Supersampling work{.samples = request.accuracy.samples,
                       .share = request.accuracy.sampleShare,
                       .leastContrast = kLeastContrast,
                       .firstSamples = std::min(kFirstSamples, request.accuracy.samples),
                       .leastDifference = kLeastDifference,
                       .curve = request.toneMap,
                       .exposureFactor = exposureFactor,
                       .transparent = builder.plan().transparent};
    RepeatedPasses(builder, work).add(firstPass, target);
    builder.addPass({.name = "supersampling",
                     .target = target,
                     .reason = "up to " + std::to_string(work.samples) +
                               " samples of pixels with contrast, by the same passes again",
                     .work = std::move(work)});
}

}  // namespace clerestory
