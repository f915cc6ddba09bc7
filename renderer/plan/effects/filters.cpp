// A filter reads one picture and writes another. Filters alternate between two targets, so that
// eight filters need as much memory as two.
#include "plan/effects/filters.h"

#include <algorithm>
#include <cmath>

namespace clerestory {
namespace {

Subject subjectOf(std::size_t index, const FilterRequest& filter) {
    return {Subject::Kind::filter, std::string(typeOf(filter)), static_cast<std::uint32_t>(index)};
}

class FilterChain {
public:
    FilterChain(FramePlan& plan, TargetId picture, float exposureFactor)
        : plan_(plan), picture_(picture), exposureFactor_(exposureFactor) {}

    TargetId picture() const { return picture_; }

    void add(const Subject& subject, const TwirlFilter& filter) {
        const double corner = std::hypot(plan_.width, plan_.height);
        Twirl work;
        work.turn = static_cast<float>(filter.amount / plan_.height);
        work.radius = static_cast<float>(filter.radius.value_or(corner));
        addStep(subject, work, "rotates pixels about the centre of the picture");
    }

    void add(const Subject& subject, const ConvolveFilter& filter) {
        const auto* word = std::get_if<KernelName>(&filter.kernel);
        const KernelNumbers kernel =
            word ? numbersOf(*word) : std::get<KernelNumbers>(filter.kernel);
        Convolve work;
        std::transform(kernel.begin(), kernel.end(), work.kernel.begin(),
                       [](double x) { return static_cast<float>(x); });
        work.repeat = filter.edge == EdgeRule::repeat;
        addStep(subject, work, "convolves each pixel with its neighbours");
    }

    // Level k of a pyramid spreads light over about 2^k pixels. All levels up to `radius` have the
    // same weight, the last one a part of it, so that a glow grows continuously with the radius.
    void add(const Subject& subject, const GlowFilter& filter) {
        const double octaves = std::log2(filter.radius);
        const auto levels = static_cast<std::uint32_t>(std::ceil(octaves));
        const auto weight = [&](std::uint32_t level) {
            return std::min(1.0, octaves - static_cast<double>(level));
        };
        const float threshold = static_cast<float>(filter.threshold) / exposureFactor_;

        std::vector<TargetId> pyramid;
        std::uint32_t width = plan_.width, height = plan_.height;
        for (std::uint32_t level = 0; level < levels; ++level) {
            width = (width + 1) / 2;
            height = (height + 1) / 2;
            const TargetId target =
                addTarget(nameOf(subject) + ":" + std::to_string(level + 1), width, height);
            if (level == 0) {
                addPass(subject, target, GlowBright{{picture_}, threshold},
                        "extracts light above the threshold");
            } else {
                addPass(subject, target, GlowDown{{pyramid.back()}}, "halves the size");
            }
            pyramid.push_back(target);
        }
        double wider = 0.0;  // weight of all smaller levels
        for (std::uint32_t level = levels - 1; level > 0; --level) {
            wider += weight(level);
            const double share = wider / (wider + weight(level - 1));
            addPass(subject, pyramid[level - 1],
                    GlowUp{{pyramid[level]}, static_cast<float>(share)},
                    "adds the next smaller level");
        }
        Glow work;
        work.spread = pyramid.front();
        work.threshold = threshold;
        // Less than an octave spreads a part of the light only.
        work.share = static_cast<float>(filter.strength * std::min(1.0, octaves));
        addStep(subject, work, "adds the spread light");
    }

private:
    TargetId addTarget(const std::string& name, std::uint32_t width, std::uint32_t height) {
        plan_.targets.push_back({.name = name,
                                 .format = plan_.targets[picture_].format,
                                 .width = width,
                                 .height = height});
        return static_cast<TargetId>(plan_.targets.size() - 1);
    }

    void addPass(const Subject& subject, TargetId target, PassWork work, const char* reason) {
        plan_.passes.push_back({.name = nameOf(subject),
                                .subject = subject,
                                .effect = Effect::filters,
                                .target = target,
                                .reason = reason,
                                .work = std::move(work)});
    }

    // Adds a pass that reads the picture and makes its target the new picture.
    template <class Work>
    void addStep(const Subject& subject, Work work, const char* reason) {
        TargetId& free = targets_[0] == picture_ ? targets_[1] : targets_[0];
        if (free == kNoTarget)
            free = addTarget("picture:" + nameOf(subject), plan_.width, plan_.height);
        work.source = picture_;
        picture_ = free;
        addPass(subject, picture_, std::move(work), reason);
    }

    FramePlan& plan_;
    TargetId picture_;
    float exposureFactor_;
    TargetId targets_[2] = {kNoTarget, kNoTarget};
};

}  // namespace

TargetId planFilters(FramePlan& plan, const std::vector<FilterRequest>& filters, TargetId picture,
                     float exposureFactor) {
    FilterChain chain(plan, picture, exposureFactor);
    for (std::size_t i = 0; i < filters.size(); ++i) {
        const Subject subject = subjectOf(i, filters[i]);
        if (std::string reason = reasonToLeaveOut(filters[i]); !reason.empty())
            plan.skipped.push_back({nameOf(subject), Effect::filters, std::move(reason), subject});
        else
            std::visit([&](const auto& filter) { chain.add(subject, filter); }, filters[i]);
    }
    return chain.picture();
}

void explainFilters(FramePlan& plan, const std::vector<FilterRequest>& filters) {
    for (std::size_t i = 0; i < filters.size(); ++i) {
        const Subject subject = subjectOf(i, filters[i]);
        plan.skipped.push_back({nameOf(subject), Effect::filters,
                                "the request selects a data channel instead of colour", subject});
    }
}

}  // namespace clerestory
