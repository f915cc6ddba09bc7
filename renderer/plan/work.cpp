// Counting, and telling which knobs it comes from.
#include "plan/work.h"

#include "plan/features.h"

#include <algorithm>
#include <map>

namespace clerestory {
namespace {

std::uint64_t texelsOf(const TargetSpec& target, bool allFaces, bool allLevels) {
    std::uint64_t texels = 0;
    for (std::uint32_t level = 0; level < (allLevels ? target.levels : 1); ++level) {
        texels += std::uint64_t{std::max(1u, target.width >> level)} *
                  std::max(1u, target.height >> level);
    }
    return allFaces ? 6 * texels : texels;
}

bool anyHas(const Pass& pass, Features feature) {
    const auto has = [&](const Draw& draw) { return (draw.features & feature) != 0; };
    return std::any_of(pass.opaqueDraws.begin(), pass.opaqueDraws.end(), has) ||
           std::any_of(pass.blendedDraws.begin(), pass.blendedDraws.end(), has);
}

// Of the scene, for each sample.
std::uint64_t lookUps(const FramePlan& plan, const Pass& pass) {
    std::uint64_t directions = 1;
    for (const ReflectedPicture& picture : pass.reflections) {
        directions = std::max<std::uint64_t>(directions, picture.samples);
    }
    if (anyHas(pass, FEATURE_MAP_SAMPLES)) {
        directions = std::max<std::uint64_t>(directions, plan.curvedSamples);
    }
    return directions + (traces(pass) ? plan.bounces : 0);
}

// The fields of a request that a pass's work comes from.
const char* knobsOf(PassKind kind) {
    switch (kind) {
        case PassKind::environment:
            return "/accuracy/environmentSize, /accuracy/environmentSamples";
        case PassKind::capture:
        case PassKind::prefilter:
        case PassKind::gaussian:
        case PassKind::levels:
            return "/accuracy/probeSize, /accuracy/probeSamples, /accuracy/generations";
        case PassKind::mirror:
            return "/accuracy/planarScale, /accuracy/generations, /accuracy/samples";
        case PassKind::twirl:
        case PassKind::convolve:
        case PassKind::glowBright:
        case PassKind::glowDown:
        case PassKind::glowUp:
        case PassKind::glow:
            return "/filters";
        case PassKind::surface:
        case PassKind::backFaces:
        case PassKind::backdrop:
        case PassKind::glass:
        case PassKind::channel:
        case PassKind::toneMap:
        case PassKind::edgeFilter:
            break;
    }
    return "/width, /height, /accuracy/samples";
}

// "/a, /b" -> the pointers.
void forEachPointer(std::string_view knobs, auto act) {
    while (!knobs.empty()) {
        const std::size_t end = std::min(knobs.find(", "), knobs.size());
        act(std::string(knobs.substr(0, end)));
        knobs.remove_prefix(std::min(end + 2, knobs.size()));
    }
}

// By knobs; the dearest first.
[[noreturn]] void refuse(std::vector<std::pair<std::uint64_t, std::string>> shares,
                         std::uint64_t most) {
    std::uint64_t all = 0;
    for (const auto& [samples, knobs] : shares) all += samples;
    std::sort(shares.rbegin(), shares.rend());
    const std::string allowed =
        "at most " + std::to_string(most) + " samples in all passes of a frame together";
    std::vector<FieldError> errors;
    for (const auto& [samples, knobs] : shares) {
        const std::string part = "has a part in " + std::to_string(samples) + " of the frame's " +
                                 std::to_string(all) + " samples";
        forEachPointer(knobs, [&](const std::string& pointer) {
            errors.push_back({pointer, part, allowed});
        });
    }
    throw InvalidRequest(std::move(errors));
}

}  // namespace

std::uint64_t shadedSamples(const FramePlan& plan, const Pass& pass) {
    if (pass.target >= plan.targets.size()) return 0;
    const TargetSpec& target = plan.targets[pass.target];
    const std::uint64_t samples = std::max(1u, target.samples);
    switch (pass.kind) {
        case PassKind::environment:
            return texelsOf(target, true, true) * plan.environmentSamples;
        case PassKind::prefilter:
            return texelsOf(target, true, true) * plan.probeSamples;
        case PassKind::gaussian:
            return texelsOf(target, true, false);
        case PassKind::levels:
            return texelsOf(target, target.kind == TargetKind::cube, true);
        default:
            return texelsOf(target, false, false) * samples * lookUps(plan, pass);
    }
}

std::uint64_t shadedSamples(const FramePlan& plan) {
    std::uint64_t sum = 0;
    for (const Pass& pass : plan.passes) sum += shadedSamples(plan, pass);
    return sum;
}

std::uint64_t leastShadedSamples(const FrameRequest& request) {
    return std::uint64_t{request.width} * request.height;
}

void requireAffordable(const FrameRequest& request, std::uint64_t most) {
    const std::uint64_t least = leastShadedSamples(request);
    if (most != 0 && least > most) refuse({{least, "/width, /height"}}, most);
}

void requireAffordable(const FramePlan& plan, std::uint64_t most) {
    if (most == 0 || shadedSamples(plan) <= most) return;
    std::map<std::string, std::uint64_t> byKnobs;
    for (const Pass& pass : plan.passes) byKnobs[knobsOf(pass.kind)] += shadedSamples(plan, pass);
    std::vector<std::pair<std::uint64_t, std::string>> shares;
    for (const auto& [knobs, samples] : byKnobs) shares.emplace_back(samples, knobs);
    refuse(std::move(shares), most);
}

}  // namespace clerestory
