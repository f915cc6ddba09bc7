#include "server/live/live_views.h"

#include <algorithm>

namespace clerestory {

std::uint64_t LiveView::put(FrameRequest request, std::string text) {
    std::vector<std::weak_ptr<CancellationToken>> outdated;
    std::uint64_t version = 0;
    {
        const std::lock_guard lock(mutex_);
        version = shown_.version + 1;
        shown_ = {std::move(request), std::move(text), version, Clock::now()};
        outdated.swap(cancellations_);
    }
    changed_.notify_all();
    for (const auto& frame : outdated) {
        if (const auto token = frame.lock()) token->cancel();
    }
    return version;
}

LiveView::Shown LiveView::shown() const {
    const std::lock_guard lock(mutex_);
    return shown_;
}

void LiveView::waitForNewer(std::uint64_t version, Clock::time_point until) const {
    std::unique_lock lock(mutex_);
    changed_.wait_until(lock, until, [&] { return shown_.version > version; });
}

std::shared_ptr<CancellationToken> LiveView::cancellationOf(std::uint64_t version) {
    auto token = std::make_shared<CancellationToken>();
    const std::lock_guard lock(mutex_);
    std::erase_if(cancellations_, [](const auto& frame) { return frame.expired(); });
    if (shown_.version == version) {
        cancellations_.push_back(token);
    } else {
        token->cancel();
    }
    return token;
}

std::shared_ptr<LiveDrawing> LiveView::drawing(
    const LiveSettings& settings, const std::function<std::shared_ptr<LiveDrawing>()>& make) {
    const std::lock_guard lock(mutex_);
    std::erase_if(drawings_, [](const auto& entry) { return entry.second.expired(); });
    auto drawing = drawings_[settings].lock();
    if (!drawing) {
        drawing = make();
        drawings_[settings] = drawing;
    }
    return drawing;
}

// With the lock held.
void LiveViews::removeOldest(const std::string& client) {
    auto oldest = views_.end();
    for (auto view = views_.begin(); view != views_.end(); ++view) {
        if (view->second.held.client() != client) continue;
        if (oldest == views_.end() || view->second.changedAt < oldest->second.changedAt) {
            oldest = view;
        }
    }
    if (oldest != views_.end()) views_.erase(oldest);
}

std::shared_ptr<LiveView> LiveViews::make(const std::string& name, const std::string& client) {
    const std::lock_guard lock(mutex_);
    auto found = views_.find(name);
    if (found == views_.end()) {
        auto held = holdings_.take(Pool::views, client, 1);
        if (!held) {
            const bool hasShare = holdings_.of(Pool::views, client) > 0;
            removeOldest(hasShare ? client : holdings_.usage(Pool::views).greatestClient);
            held = holdings_.take(Pool::views, client, 1);
        }
        if (!held) throw RequestError(streamsFull());
        found = views_
                    .emplace(name,
                             Entry{.view = std::make_shared<LiveView>(), .held = *std::move(held)})
                    .first;
    }
    found->second.changedAt = ++count_;
    return found->second.view;
}

std::shared_ptr<LiveView> LiveViews::find(const std::string& name) const {
    const std::lock_guard lock(mutex_);
    const auto found = views_.find(name);
    return found == views_.end() ? nullptr : found->second.view;
}

}  // namespace clerestory
