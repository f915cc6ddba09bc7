#include "plan/graph/picture_passes.h"

namespace clerestory {

std::uint64_t PicturePass::shadedSamples(const TargetSpec& target, const SampleFactors&) const {
    return texelsOf(target, Faces::one, Levels::first);
}

std::string_view AssembleLens::knobs() const {
    return kKnobsOfTheFrame;
}
std::uint64_t AssembleLens::shadedSamples(const TargetSpec& target, const SampleFactors&) const {
    return texelsOf(target, Faces::one, Levels::first);
}

std::string_view BackgroundAlpha::knobs() const {
    return kKnobsOfTheFrame;
}

std::string_view StraightAlpha::knobs() const {
    return kKnobsOfTheFrame;
}

std::string_view ToneMapping::knobs() const {
    return kKnobsOfTheFrame;
}

std::string_view EdgeFilter::knobs() const {
    return kKnobsOfTheFrame;
}

}  // namespace clerestory
