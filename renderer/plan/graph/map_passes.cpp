#include "plan/graph/map_passes.h"

#include "plan/graph/frame_plan.h"

namespace clerestory {
namespace {

constexpr std::string_view kKnobsOfCubes =
    "/accuracy/probeSize, /accuracy/probeSamples, /accuracy/generations";

}  // namespace

std::string_view PrefilterMap::knobs() const {
    return "/accuracy/environmentSize, /accuracy/environmentSamples";
}
std::uint64_t PrefilterMap::shadedSamples(const TargetSpec& target, const FramePlan&) const {
    return texelsOf(target, Faces::all, Levels::all) * samples;
}
void PrefilterMap::addTo(PlanHash& hash, const Stage&) const {
    hash.add(map);
    hash.add(samples);
}

std::string_view PrefilterCube::knobs() const {
    return kKnobsOfCubes;
}
std::uint64_t PrefilterCube::shadedSamples(const TargetSpec& target, const FramePlan&) const {
    return texelsOf(target, Faces::all, Levels::all) * samples;
}
void PrefilterCube::addTo(PlanHash& hash, const Stage&) const {
    hash.add(samples);
}

std::vector<TargetId> BlurCube::reads() const {
    return source == kNoTarget ? std::vector<TargetId>{} : std::vector{source};
}
std::string_view BlurCube::knobs() const {
    return kKnobsOfCubes;
}
std::uint64_t BlurCube::shadedSamples(const TargetSpec& target, const FramePlan&) const {
    return texelsOf(target, Faces::all, Levels::first);
}
void BlurCube::addTo(PlanHash& hash, const Stage&) const {
    hash.add(map);
    hash.add(blur.size);
    hash.add(blur.stdev);
    hash.add(axis);
}

std::string_view BuildLevels::knobs() const {
    return kKnobsOfCubes;
}
std::uint64_t BuildLevels::shadedSamples(const TargetSpec& target, const FramePlan&) const {
    return texelsOf(target, target.kind == TargetKind::cube ? Faces::all : Faces::one, Levels::all);
}
void BuildLevels::addTo(PlanHash&, const Stage&) const {}

}  // namespace clerestory
