#include "server/worker/quarantine.h"

#include "scene/hash.h"

#include <algorithm>

namespace clerestory {

std::uint64_t fingerprintOf(const WorkerRequest& request) {
    if (const auto* call = std::get_if<Call>(&request)) {
        std::string text = call->method + '\n' + call->path + '\n';
        for (const auto& [name, value] : call->query) text += name + '=' + value + '\n';
        text += '\n' + call->body;
        return hashOf(text);
    }
    if (const auto* order = std::get_if<FrameOrder>(&request)) {
        return hashOf(packed(FrameOrder{.request = order->request, .withPlan = order->withPlan}));
    }
    return hashOf(std::get<SceneQuery>(request).id);
}

void Quarantine::add(std::uint64_t fingerprint, Clock::time_point now) {
    const std::lock_guard lock(mutex_);
    if (until_.size() >= kMax) {
        until_.erase(
            std::min_element(until_.begin(), until_.end(),
                             [](const auto& a, const auto& b) { return a.second < b.second; }));
    }
    until_[fingerprint] = now + kLifetime;
}

bool Quarantine::contains(std::uint64_t fingerprint, Clock::time_point now) const {
    const std::lock_guard lock(mutex_);
    const auto found = until_.find(fingerprint);
    return found != until_.end() && now < found->second;
}

}  // namespace clerestory
