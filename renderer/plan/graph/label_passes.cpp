#include "plan/graph/label_passes.h"

#include <algorithm>

namespace clerestory {

std::string_view MeasureFlow::knobs() const {
    return kKnobsOfTheFrame;
}
std::uint64_t MeasureFlow::shadedSamples(const TargetSpec& target, const SampleFactors&) const {
    return texelsOf(target, Faces::one, Levels::first);
}

std::string_view FollowLayer::knobs() const {
    return kKnobsOfTheFrame;
}
std::uint64_t FollowLayer::shadedSamples(const TargetSpec& target,
                                         const SampleFactors& factors) const {
    return texelsOf(target, Faces::one, Levels::first) * std::max<std::uint64_t>(1, factors.rayBounces);
}

std::string_view MeasureInstances::knobs() const {
    return kKnobsOfTheFrame;
}
std::uint64_t MeasureInstances::shadedSamples(const TargetSpec&, const SampleFactors&) const {
    std::uint64_t samples = 0;
    for (const Alone& alone : instances) {
        samples += std::uint64_t{alone.rect.width} * alone.rect.height;
    }
    return samples;
}

}  // namespace clerestory
