#include "server/worker/renderer_queue.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace clerestory {
namespace {

// How soon a waiting entry sees that its client has left, that a renderer has loaded its scene, or
// that its time is over.
constexpr std::chrono::milliseconds kQueuePollInterval{50};

bool holds(const RendererState& state, const std::string& scene) {
    if (!state.isPresent || !state.loaded) return false;
    const std::string& id = scene.empty() ? state.loaded->defaultScene : scene;
    const auto& scenes = state.loaded->scenes;
    return std::any_of(scenes.begin(), scenes.end(),
                       [&](const auto& one) { return one.first == id; });
}

}  // namespace

std::size_t firstRenderer(const std::vector<RendererState>& states) {
    const auto found = std::find_if(states.begin(), states.end(),
                                    [](const RendererState& state) { return state.isPresent; });
    return found == states.end() ? 0 : static_cast<std::size_t>(found - states.begin());
}

std::shared_ptr<const LoadedScenes> loadedInAll(const std::vector<RendererState>& states) {
    std::vector<std::shared_ptr<const LoadedScenes>> warm;
    for (const RendererState& state : states) {
        if (state.loaded) warm.push_back(state.loaded);
    }
    if (warm.size() < 2) return warm.empty() ? nullptr : warm.front();
    auto all = std::make_shared<LoadedScenes>(
        LoadedScenes{warm.front()->defaultScene, warm.front()->renderer, {}});
    std::map<std::string, std::set<std::uint64_t>> contents;
    for (const auto& loaded : warm) {
        if (loaded->renderer != all->renderer) return all;
        for (const auto& [id, hash] : loaded->scenes) contents[id].insert(hash);
    }
    for (const auto& [id, hashes] : contents) {
        if (hashes.size() == 1) all->scenes.emplace_back(id, *hashes.begin());
    }
    return all;
}

bool isLoaded(const std::vector<RendererState>& states, const std::string& scene) {
    return std::any_of(states.begin(), states.end(),
                       [&](const RendererState& state) { return holds(state, scene); });
}

bool mayDraw(const std::vector<RendererState>& states, const RendererNeed& need,
             std::size_t renderer) {
    const bool isFirst = renderer == firstRenderer(states);
    if (need.onlyFirst) return isFirst;
    if (holds(states[renderer], need.scene)) return true;
    return isFirst && !isLoaded(states, need.scene);
}

// With the lock held: the time without that of compilation.
Clock::time_point RendererQueue::queueTime(const std::vector<RendererState>& states) {
    const auto now = Clock::now();
    const bool compiles = std::any_of(states.begin(), states.end(), [](const RendererState& state) {
        return state.isPresent && state.isCompiling;
    });
    if (compiles && !compilingSince_) compilingSince_ = now;
    if (!compiles && compilingSince_) {
        compiled_ += now - *compilingSince_;
        compilingSince_.reset();
    }
    return compilingSince_.value_or(now) - compiled_;
}

RendererQueue::Place RendererQueue::take(const Turn& turn, const RendererNeed& need) {
    const auto patience = std::chrono::duration_cast<Clock::duration>(turn.patience);
    const auto longest =
        Clock::now() + patience + std::chrono::duration_cast<Clock::duration>(turn.compilePatience);
    Waiting own{.need = need, .renderer = {}, .problem = {}};
    std::unique_lock lock(mutex_);
    if (refusing_) throw RequestError(shuttingDown());
    const auto now = queueTime(states_());
    const auto deadline = now + patience;
    if (deadline <= now) throw RequestError(overDeadline(turn.patience.count()));
    const FairQueue::Added added = queue_.add({turn.client, turn.kind, deadline}, now);
    for (const FairQueue::Id out : added.evicted) {
        waiting_.at(out)->problem = queueFull(queue_.retryAfterSeconds());
        waiting_.erase(out);
    }
    if (!added.evicted.empty()) changed_.notify_all();
    if (!added.id) throw RequestError(queueFull(queue_.retryAfterSeconds()));
    const FairQueue::Id id = *added.id;
    try {
        waiting_.emplace(id, &own);
        dispatch();
        while (!own.renderer && !own.problem) {
            if (turn.cancellation && turn.cancellation->cancelled()) {
                throw RequestError(clientLeft());
            }
            const auto left = deadline - queueTime(states_());
            if (left <= Clock::duration::zero()) {
                throw RequestError(overDeadline(turn.patience.count()));
            }
            if (Clock::now() >= longest) throw RequestError(stillCompiling(0));
            changed_.wait_for(lock, std::min<Clock::duration>(left, kQueuePollInterval));
            dispatch();
        }
    } catch (...) {
        queue_.remove(id);
        waiting_.erase(id);
        for (auto& entry : busy_) {  // out of memory after it was started
            if (entry != id) continue;
            queue_.finished(id, now);
            entry.reset();
        }
        throw;
    }
    if (own.problem) throw RequestError(*own.problem);
    return {*this, *own.renderer};
}

// With the lock held: starts what can start now.
void RendererQueue::dispatch() {
    if (waiting_.empty() || std::none_of(busy_.begin(), busy_.end(),
                                         [](const auto& entry) { return !entry.has_value(); })) {
        return;
    }
    const std::vector<RendererState> states = states_();
    bool anything = false;
    for (std::size_t renderer = 0; renderer < busy_.size(); ++renderer) {
        if (busy_[renderer]) continue;
        const FairQueue::Next next = queue_.next(queueTime(states), [&](FairQueue::Id id) {
            return mayDraw(states, waiting_.at(id)->need, renderer);
        });
        for (const FairQueue::Id late : next.expired) {
            waiting_.at(late)->problem = overDeadline(0.0);
            waiting_.erase(late);
        }
        anything = anything || next.id || !next.expired.empty();
        if (!next.id) continue;
        busy_[renderer] = next.id;
        waiting_.at(*next.id)->renderer = renderer;
        waiting_.erase(*next.id);
    }
    if (anything) changed_.notify_all();
}

void RendererQueue::leave(std::size_t renderer) {
    const std::lock_guard lock(mutex_);
    queue_.finished(*busy_[renderer], queueTime(states_()));
    busy_[renderer].reset();
    dispatch();
    changed_.notify_all();
}

std::optional<Problem> RendererQueue::refusalFor(const std::string& client) const {
    const std::lock_guard lock(mutex_);
    if (refusing_) return shuttingDown();
    if (queue_.refuses(client)) return queueFull(queue_.retryAfterSeconds());
    return std::nullopt;
}

void RendererQueue::refuseNew() {
    std::unique_lock lock(mutex_);
    refusing_ = true;
    changed_.wait(lock, [&] {
        return waiting_.empty() && std::none_of(busy_.begin(), busy_.end(), [](const auto& entry) {
                   return entry.has_value();
               });
    });
}

QueueUsage RendererQueue::usage() const {
    const std::lock_guard lock(mutex_);
    return queue_.usage();
}

bool RendererQueue::hasRoom() const {
    const std::lock_guard lock(mutex_);
    return queue_.hasRoom();
}

}  // namespace clerestory
