#include "server/api/compact_passes.h"

#include <algorithm>

namespace clerestory {
namespace {

// Plain ASCII without separators of the list.
std::string headerWord(std::string_view text) {
    std::string word(text);
    for (char& c : word) c = c > ' ' && c < 127 && c != ',' ? c : '_';
    return word;
}

std::string counted(std::string_view kind, std::size_t count) {
    return std::string(kind) + '*' + std::to_string(count);
}

// The name of a pass; a run of one kind as `capture*48`.
std::string runsOf(const FramePlan& plan) {
    std::string text;
    for (auto it = plan.passes.begin(); it != plan.passes.end();) {
        const auto end = std::find_if(it, plan.passes.end(),
                                      [&](const Pass& pass) { return pass.kind() != it->kind(); });
        const auto count = static_cast<std::size_t>(end - it);
        text += text.empty() ? "" : ", ";
        text += count == 1 ? headerWord(it->name) : counted(it->kind(), count);
        it = end;
    }
    return text;
}

// Each kind once with its count, in the order of first use.
std::string kindsOf(const FramePlan& plan) {
    std::vector<std::pair<std::string_view, std::size_t>> kinds;
    for (const Pass& pass : plan.passes) {
        const auto known = std::find_if(kinds.begin(), kinds.end(),
                                        [&](const auto& k) { return k.first == pass.kind(); });
        if (known == kinds.end())
            kinds.emplace_back(pass.kind(), 1);
        else
            ++known->second;
    }
    std::string text;
    for (const auto& [kind, count] : kinds) {
        text += (text.empty() ? "" : ", ") + counted(kind, count);
    }
    return text;
}

}  // namespace

std::string compactPasses(const FramePlan& plan) {
    const std::string runs = runsOf(plan);
    return runs.size() <= kMaxCompactPasses ? runs : kindsOf(plan);
}

}  // namespace clerestory
