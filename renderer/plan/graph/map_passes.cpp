#include "plan/graph/map_passes.h"

namespace clerestory {
namespace {

constexpr std::string_view kKnobsOfCubes =
    "/accuracy/probeSize, /accuracy/probeSamples, /accuracy/generations";

}  // namespace

void addBlur(PlanHash& hash, const MapBlur& blur) {
    const auto& [size, stdev] = blur;
    hash.add(size);
    hash.add(stdev);
}

std::string_view PrefilterMap::knobs() const {
    return "/accuracy/environmentSize, /accuracy/environmentSamples";
}
std::uint64_t PrefilterMap::shadedSamples(const TargetSpec& target, const SampleFactors&) const {
    return texelsOf(target, Faces::all, Levels::all) * samples;
}
void addTo(PlanHash& hash, const PrefilterMap& work, const Stage&) {
    const auto& [map, samples] = work;
    hash.add(map);
    hash.add(samples);
}

std::string_view PrefilterCube::knobs() const {
    return kKnobsOfCubes;
}
std::uint64_t PrefilterCube::shadedSamples(const TargetSpec& target, const SampleFactors&) const {
    return texelsOf(target, Faces::all, Levels::all) * samples;
}
void addTo(PlanHash& hash, const PrefilterCube& work, const Stage&) {
    const auto& [source, samples] = work;  // reads(): source
    hash.add(samples);
}

std::vector<TargetId> BlurCube::reads() const {
    return source == kNoTarget ? std::vector<TargetId>{} : std::vector{source};
}
std::string_view BlurCube::knobs() const {
    return kKnobsOfCubes;
}
std::uint64_t BlurCube::shadedSamples(const TargetSpec& target, const SampleFactors&) const {
    return texelsOf(target, Faces::all, Levels::first);
}
void addTo(PlanHash& hash, const BlurCube& work, const Stage&) {
    const auto& [source, map, blur, axis] = work;  // reads(): source
    hash.add(map);
    addBlur(hash, blur);
    hash.add(axis);
}

std::string_view BuildLevels::knobs() const {
    return kKnobsOfCubes;
}
std::uint64_t BuildLevels::shadedSamples(const TargetSpec& target, const SampleFactors&) const {
    return texelsOf(target, target.kind == TargetKind::cube ? Faces::all : Faces::one, Levels::all);
}
void addTo(PlanHash&, const BuildLevels&, const Stage&) {}

}  // namespace clerestory
