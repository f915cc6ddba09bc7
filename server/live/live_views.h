// Views that are watched live: a name, and the frame request that was put there last. Thread-safe.
#pragma once

#include "plan/request/frame_request.h"
#include "server/base/call.h"
#include "server/base/holdings.h"
#include "server/base/process.h"

#include <compare>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace clerestory {

class LiveDrawing;

struct LiveSettings {
    double targetMs = 0.0;  // of a frame in motion; 0: every frame is the request itself
    double playRate = 0.0;  // frames per second of a stream whose time is the clock's; 0: none
    auto operator<=>(const LiveSettings&) const = default;
};

class LiveView {
public:
    struct Shown {
        FrameRequest request;
        std::string text;           // the body of the client: sent back unparsed
        std::uint64_t version = 0;  // number of its put()
        Clock::time_point since;    // time of its put()
    };

    // Returns the new version. Cancels the frames of earlier ones.
    std::uint64_t put(FrameRequest request, std::string text);
    Shown shown() const;
    // Returns when there is a newer version, or at that time.
    void waitForNewer(std::uint64_t version, Clock::time_point until) const;

    // Cancelled by put(); at once if there is a newer version already.
    std::shared_ptr<CancellationToken> cancellationOf(std::uint64_t version);

    // What `make` returned for equal settings, as long as it is held; otherwise calls `make`.
    std::shared_ptr<LiveDrawing> drawing(const LiveSettings& settings,
                                         const std::function<std::shared_ptr<LiveDrawing>()>& make);

private:
    mutable std::mutex mutex_;
    mutable std::condition_variable changed_;
    Shown shown_;
    std::vector<std::weak_ptr<CancellationToken>> cancellations_;
    std::map<LiveSettings, std::weak_ptr<LiveDrawing>> drawings_;
};

class LiveViews {
public:
    explicit LiveViews(Holdings& holdings) : holdings_(holdings) {}

    // The view with this name; creates it for the client if there is none. A client that has its
    // share (server/base/holdings.h) then loses the one of its views that was created or changed
    // longest ago; if there are views of too many clients, the client with the most loses one. The
    // streams of a removed view go on with what they show.
    std::shared_ptr<LiveView> make(const std::string& name, const std::string& client);
    // Null if there is none.
    std::shared_ptr<LiveView> find(const std::string& name) const;

private:
    struct Entry {
        std::shared_ptr<LiveView> view;
        std::uint64_t changedAt = 0;
        Holdings::Held held;
    };
    void removeOldest(const std::string& client);

    Holdings& holdings_;
    mutable std::mutex mutex_;
    std::map<std::string, Entry> views_;
    std::uint64_t count_ = 0;
};

}  // namespace clerestory
