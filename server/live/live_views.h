// Views that are watched live: a name, the frame request that was put there last, and the picture
// that was drawn of it last, so that many watchers cost one frame. Thread-safe.
#pragma once

#include "plan/request/frame_request.h"
#include "server/base/process.h"

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

namespace clerestory {

class LiveView {
public:
    struct Shown {
        FrameRequest request;
        std::string text;  // the body of the client: sent back unparsed
        std::uint64_t version = 0;
    };

    void put(FrameRequest request, std::string text);
    Shown shown() const;
    // Returns when there is a newer version, or at that time.
    void waitForNewer(std::uint64_t version, Clock::time_point until) const;

    // The picture with this key: the last one, or else the result of `draw`, which is stored. Calls
    // wait for each other. Throws what `draw` throws.
    using Picture = std::shared_ptr<const std::string>;
    Picture picture(const std::string& key, const std::function<std::string()>& draw);

private:
    mutable std::mutex mutex_;
    mutable std::condition_variable changed_;
    Shown shown_;
    std::mutex drawing_;
    std::string drawnKey_;
    Picture drawn_;
};

class LiveViews {
public:
    static constexpr std::size_t kMax = 64;

    // The view with this name; creates it if there is none, and then removes the view that was
    // created or changed longest ago if there are too many. Its streams go on with what they show.
    std::shared_ptr<LiveView> make(const std::string& name);
    // Null if there is none.
    std::shared_ptr<LiveView> find(const std::string& name) const;

private:
    struct Entry {
        std::shared_ptr<LiveView> view;
        std::uint64_t changedAt = 0;
    };
    mutable std::mutex mutex_;
    std::map<std::string, Entry> views_;
    std::uint64_t count_ = 0;
};

}  // namespace clerestory
