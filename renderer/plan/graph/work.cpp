// Counting, and telling which knobs it comes from.
#include "plan/graph/work.h"

#include <algorithm>
#include <map>

namespace clerestory {
namespace {

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
    return std::visit([&](const auto& work) { return work.shadedSamples(target, plan); },
                      pass.work);
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
    for (const Pass& pass : plan.passes) {
        byKnobs[std::string(pass.knobs())] += shadedSamples(plan, pass);
    }
    std::vector<std::pair<std::uint64_t, std::string>> shares;
    for (const auto& [knobs, samples] : byKnobs) shares.emplace_back(samples, knobs);
    refuse(std::move(shares), most);
}

}  // namespace clerestory
