#include "server/live/live_views.h"

#include <algorithm>

namespace clerestory {

void LiveView::put(FrameRequest request, std::string text) {
    {
        const std::lock_guard lock(mutex_);
        shown_ = {std::move(request), std::move(text), shown_.version + 1};
    }
    changed_.notify_all();
}

LiveView::Shown LiveView::shown() const {
    const std::lock_guard lock(mutex_);
    return shown_;
}

void LiveView::waitForNewer(std::uint64_t version, Clock::time_point until) const {
    std::unique_lock lock(mutex_);
    changed_.wait_until(lock, until, [&] { return shown_.version > version; });
}

LiveView::Picture LiveView::picture(const std::string& key,
                                    const std::function<std::string()>& draw) {
    const std::lock_guard lock(drawing_);
    if (!drawn_ || key != drawnKey_) {
        drawn_ = std::make_shared<const std::string>(draw());
        drawnKey_ = key;
    }
    return drawn_;
}

std::shared_ptr<LiveView> LiveViews::make(const std::string& name) {
    const std::lock_guard lock(mutex_);
    if (!views_.contains(name) && views_.size() == kMax) {
        views_.erase(std::min_element(
            views_.begin(), views_.end(),
            [](const auto& a, const auto& b) { return a.second.changedAt < b.second.changedAt; }));
    }
    Entry& entry = views_[name];
    if (!entry.view) entry.view = std::make_shared<LiveView>();
    entry.changedAt = ++count_;
    return entry.view;
}

std::shared_ptr<LiveView> LiveViews::find(const std::string& name) const {
    const std::lock_guard lock(mutex_);
    const auto found = views_.find(name);
    return found == views_.end() ? nullptr : found->second.view;
}

}  // namespace clerestory
