#include "server/live/live_views.h"

#include <algorithm>

namespace clerestory {

void LiveView::put(nlohmann::json body) {
    {
        const std::lock_guard lock(mutex_);
        shown_ = {std::move(body), shown_.version + 1};
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

LiveView::Picture LiveView::picture(const std::string& body,
                                    const std::function<std::string()>& draw) {
    const std::lock_guard lock(drawing_);
    if (!drawn_ || body != drawnBody_) {
        drawn_ = std::make_shared<const std::string>(draw());
        drawnBody_ = body;
    }
    return drawn_;
}

std::shared_ptr<LiveView> LiveViews::make(const std::string& name) {
    const std::lock_guard lock(mutex_);
    if (!views_.contains(name) && views_.size() == kMax) {
        views_.erase(std::min_element(
            views_.begin(), views_.end(),
            [](const auto& a, const auto& b) { return a.second.madeAt < b.second.madeAt; }));
    }
    Held& held = views_[name];
    if (!held.view) held.view = std::make_shared<LiveView>();
    held.madeAt = ++count_;
    return held.view;
}

std::shared_ptr<LiveView> LiveViews::find(const std::string& name) const {
    const std::lock_guard lock(mutex_);
    const auto found = views_.find(name);
    return found == views_.end() ? nullptr : found->second.view;
}

}  // namespace clerestory
