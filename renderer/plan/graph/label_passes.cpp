#include "plan/graph/label_passes.h"

#include <algorithm>

namespace clerestory {
namespace {

std::uint64_t raysOfLayer(const TargetSpec& target, const SampleFactors& factors) {
    return texelsOf(target, Faces::one, Levels::first) *
           std::max<std::uint64_t>(1, factors.rayBounces);
}

}  // namespace

std::string_view MeasureFlow::knobs() const {
    return kKnobsOfTheFrame;
}
std::uint64_t MeasureFlow::shadedSamples(const TargetSpec& target,
                                         const SampleFactors& factors) const {
    // The search takes 7 to 13 rays for most pixels of flat and curved mirrors and of a glass ball.
    constexpr std::uint64_t kRaysOfSearch = 10;
    return layer == OutputLayer::direct ? texelsOf(target, Faces::one, Levels::first)
                                        : kRaysOfSearch * raysOfLayer(target, factors);
}

std::string_view FollowLayer::knobs() const {
    return kKnobsOfTheFrame;
}
std::uint64_t FollowLayer::shadedSamples(const TargetSpec& target,
                                         const SampleFactors& factors) const {
    return raysOfLayer(target, factors);
}

std::string_view CountLayer::knobs() const {
    return kKnobsOfTheFrame;
}
std::uint64_t CountLayer::shadedSamples(const TargetSpec& target,
                                        const SampleFactors& factors) const {
    return raysOfLayer(target, factors);
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
