#include "plan/graph/work.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace clerestory {
namespace {

// Calls act for each JSON Pointer of "/a, /b".
void forEachPointer(std::string_view knobs, auto act) {
    while (!knobs.empty()) {
        const std::size_t end = std::min(knobs.find(", "), knobs.size());
        act(std::string(knobs.substr(0, end)));
        knobs.remove_prefix(std::min(end + 2, knobs.size()));
    }
}

// shares: samples and the knobs that determine them. The errors are in descending order of cost.
[[noreturn]] void refuse(std::vector<std::pair<std::uint64_t, std::string>> shares,
                         std::uint64_t maxSamples) {
    std::uint64_t all = 0;
    for (const auto& [samples, knobs] : shares) all += samples;
    std::sort(shares.rbegin(), shares.rend());
    const std::string allowed =
        "at most " + std::to_string(maxSamples) + " samples in all passes of a frame together";
    std::vector<FieldError> errors;
    for (const auto& [samples, knobs] : shares) {
        const std::string part = "contributes to " + std::to_string(samples) + " of the " +
                                 std::to_string(all) + " samples of the frame";
        forEachPointer(knobs, [&](const std::string& pointer) {
            errors.push_back({pointer, part, allowed});
        });
    }
    throw InvalidRequest(std::move(errors));
}

SampleFactors factorsOf(const FramePlan& plan) {
    SampleFactors factors{.curvedSamples = plan.curvedSamples};
    if (plan.rays) {
        factors.rayBounces = plan.rays->bounces;
        factors.lobePaths = std::max(plan.rays->lobePaths, plan.rays->glassLobePaths);
    }
    return factors;
}

std::uint64_t samplesOf(const FramePlan& plan, const Pass& pass, const SampleFactors& factors) {
    if (pass.target >= plan.targets.size()) return 0;
    const TargetSpec& target = plan.targets[pass.target];
    return std::visit([&](const auto& work) { return work.shadedSamples(target, factors); },
                      pass.work);
}

}  // namespace

std::uint64_t shadedSamples(const FramePlan& plan, const Pass& pass) {
    SampleFactors factors = factorsOf(plan);
    const std::uint64_t own = samplesOf(plan, pass, factors);
    const auto* supersampling = std::get_if<Supersampling>(&pass.work);
    if (!supersampling) return own;
    factors.lobePaths = 1;  // as FollowRays is executed for further samples
    std::uint64_t once = 0;
    for (const auto& [repeated, part] : supersampling->passes) {
        once += samplesOf(plan, plan.passes[repeated], factors);
    }
    return own + static_cast<std::uint64_t>(std::ceil(
                     supersampling->share * double(supersampling->samples - 1) * double(once)));
}

std::uint64_t shadedSamples(const FramePlan& plan) {
    std::uint64_t sum = 0;
    for (const Pass& pass : plan.passes) sum += shadedSamples(plan, pass);
    return sum;
}

std::uint64_t minShadedSamples(const FrameRequest& request) {
    return std::uint64_t{request.width} * request.height;
}

void requireAffordable(const FrameRequest& request, std::uint64_t maxSamples) {
    const std::uint64_t samples = minShadedSamples(request);
    if (maxSamples != 0 && samples > maxSamples) refuse({{samples, "/width, /height"}}, maxSamples);
}

void requireAffordable(const FramePlan& plan, std::uint64_t maxSamples) {
    if (maxSamples == 0 || shadedSamples(plan) <= maxSamples) return;
    std::map<std::string, std::uint64_t> byKnobs;
    for (const Pass& pass : plan.passes) {
        byKnobs[std::string(pass.knobs())] += shadedSamples(plan, pass);
    }
    std::vector<std::pair<std::uint64_t, std::string>> shares;
    for (const auto& [knobs, samples] : byKnobs) shares.emplace_back(samples, knobs);
    refuse(std::move(shares), maxSamples);
}

}  // namespace clerestory
