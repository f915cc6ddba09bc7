// Views that are watched live: a name, the frame's request that was last put there, and the picture
// last drawn of it, so that many watchers cost one. Thread-safe.
#pragma once

#include "server/queue/render_queue.h"

#include <nlohmann/json.hpp>

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

namespace clerestory {

class LiveView {
public:
    struct Shown {
        nlohmann::json body;  // of a POST /v1/frames
        std::uint64_t version = 0;
    };

    void put(nlohmann::json body);
    Shown shown() const;
    // Returns when there is a newer one, or at the time given.
    void waitForNewer(std::uint64_t version, Clock::time_point until) const;

    // The picture of that body: the kept one, or what `draw` makes, which is kept. One draws at a
    // time. Throws what `draw` throws.
    using Picture = std::shared_ptr<const std::string>;
    Picture picture(const std::string& body, const std::function<std::string()>& draw);

private:
    mutable std::mutex mutex_;
    mutable std::condition_variable changed_;
    Shown shown_;
    std::mutex drawing_;
    std::string drawnBody_;
    Picture drawn_;
};

class LiveViews {
public:
    static constexpr std::size_t kMax = 64;

    // The view of that name, made when there is none; the one made or put to longest ago goes when
    // there are too many, and those who watch it keep what they see.
    std::shared_ptr<LiveView> make(const std::string& name);
    // Null when there is none.
    std::shared_ptr<LiveView> find(const std::string& name) const;

private:
    struct Held {
        std::shared_ptr<LiveView> view;
        std::uint64_t madeAt = 0;
    };
    mutable std::mutex mutex_;
    std::map<std::string, Held> views_;
    std::uint64_t count_ = 0;
};

}  // namespace clerestory
