// A filter reads the picture and writes another. Two of those take turns, so that eight filters
// need no more memory than two.
#include "plan/filters.h"

#include <algorithm>
#include <cmath>

namespace clerestory {
namespace {

std::string nameOf(std::size_t index, FilterType type) {
    const char* words[] = {"twirl", "convolve", "glow"};
    return "filter" + std::to_string(index) + ":" + words[static_cast<int>(type)];
}

class FilterChain {
public:
    FilterChain(FramePlan& plan, TargetId picture) : plan_(plan), picture_(picture) {}

    TargetId picture() const { return picture_; }

    void add(const std::string& name, const FilterRequest& filter) {
        switch (*filter.type) {
            case FilterType::twirl:
                twirl(name, filter);
                break;
            case FilterType::convolve:
                convolve(name, filter);
                break;
            case FilterType::glow:
                glow(name, filter);
                break;
        }
    }

private:
    TargetId addTarget(const std::string& name, std::uint32_t width, std::uint32_t height) {
        plan_.targets.push_back({.name = name,
                                 .format = plan_.targets[picture_].format,
                                 .width = width,
                                 .height = height});
        return static_cast<TargetId>(plan_.targets.size() - 1);
    }

    Pass& addPass(PassKind kind, const std::string& name, TargetId target,
                  std::vector<TargetId> reads, const char* reason) {
        plan_.passes.push_back({.kind = kind,
                                .name = name,
                                .effect = Effect::filters,
                                .target = target,
                                .reads = std::move(reads),
                                .reason = reason});
        return plan_.passes.back();
    }

    // A pass from the picture, and whatever else it reads, to the next.
    Pass& addStep(PassKind kind, const std::string& name, std::vector<TargetId> more,
                  const char* reason) {
        TargetId& free = turns_[0] == picture_ ? turns_[1] : turns_[0];
        if (free == kNoTarget) free = addTarget("picture:" + name, plan_.width, plan_.height);
        more.insert(more.begin(), picture_);
        picture_ = free;
        return addPass(kind, name, picture_, std::move(more), reason);
    }

    void twirl(const std::string& name, const FilterRequest& filter) {
        const double corner = std::hypot(plan_.width, plan_.height);
        PictureFilter& numbers =
            addStep(PassKind::twirl, name, {}, "turns the picture about its centre").filter;
        numbers.turn = static_cast<float>(*filter.amount / plan_.height);
        numbers.radius = static_cast<float>(filter.radius.value_or(corner));
    }

    void convolve(const std::string& name, const FilterRequest& filter) {
        const auto* word = std::get_if<KernelName>(&*filter.kernel);
        const KernelNumbers kernel =
            word ? numbersOf(*word) : std::get<KernelNumbers>(*filter.kernel);
        PictureFilter& numbers =
            addStep(PassKind::convolve, name, {}, "weighs each pixel with its neighbours").filter;
        std::transform(kernel.begin(), kernel.end(), numbers.kernel.begin(),
                       [](double x) { return static_cast<float>(x); });
        numbers.repeat = filter.edge == EdgeRule::repeat;
    }

    // Level k of a pyramid spreads light over about 2^k pixels. All levels that `radius` reaches
    // weigh the same, the last one as far as it is reached, so that a glow grows evenly with it.
    void glow(const std::string& name, const FilterRequest& filter) {
        const double octaves = std::log2(filter.radius.value_or(kDefaultGlowRadius));
        const auto levels = static_cast<std::uint32_t>(std::ceil(octaves));
        const auto weight = [&](std::uint32_t level) {
            return std::min(1.0, octaves - static_cast<double>(level));
        };
        const float threshold =
            static_cast<float>(filter.threshold.value_or(kDefaultGlowThreshold)) /
            plan_.exposureFactor;

        std::vector<TargetId> pyramid;
        std::uint32_t width = plan_.width, height = plan_.height;
        for (std::uint32_t level = 0; level < levels; ++level) {
            width = (width + 1) / 2;
            height = (height + 1) / 2;
            const TargetId above = level == 0 ? picture_ : pyramid.back();
            pyramid.push_back(addTarget(name + ":" + std::to_string(level + 1), width, height));
            Pass& down = level == 0 ? addPass(PassKind::glowBright, name, pyramid.back(), {above},
                                              "what is brighter than the threshold")
                                    : addPass(PassKind::glowDown, name, pyramid.back(), {above},
                                              "spreads it twice as wide");
            if (level == 0) down.filter.threshold = threshold;
        }
        double wider = 0.0;  // weight of all levels below
        for (std::uint32_t level = levels - 1; level > 0; --level) {
            wider += weight(level);
            addPass(PassKind::glowUp, name, pyramid[level - 1], {pyramid[level]},
                    "adds up what is spread")
                .filter.share = static_cast<float>(wider / (wider + weight(level - 1)));
        }
        PictureFilter& numbers =
            addStep(PassKind::glow, name, {pyramid.front()}, "spreads what is bright").filter;
        numbers.threshold = threshold;
        // Below an octave the rest stays where it is.
        numbers.share = static_cast<float>(filter.strength.value_or(kDefaultGlowStrength) *
                                           std::min(1.0, octaves));
    }

    FramePlan& plan_;
    TargetId picture_;
    TargetId turns_[2] = {kNoTarget, kNoTarget};
};

}  // namespace

TargetId planFilters(FramePlan& plan, const std::vector<FilterRequest>& filters, TargetId picture) {
    FilterChain chain(plan, picture);
    for (std::size_t i = 0; i < filters.size(); ++i) {
        const std::string name = nameOf(i, *filters[i].type);
        if (std::string reason = reasonToLeaveOut(filters[i]); !reason.empty())
            plan.skipped.push_back({name, Effect::filters, std::move(reason)});
        else
            chain.add(name, filters[i]);
    }
    return chain.picture();
}

void explainFilters(FramePlan& plan, const std::vector<FilterRequest>& filters) {
    for (std::size_t i = 0; i < filters.size(); ++i) {
        plan.skipped.push_back({nameOf(i, *filters[i].type), Effect::filters,
                                "the request asks for numbers instead of colour"});
    }
}

}  // namespace clerestory
