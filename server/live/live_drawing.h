// Draws the pictures of a live view for all of its streams with equal settings, so that many
// watchers cost one frame. A picture in motion always shows the newest request: of those that were
// put while a frame was drawn, only the last one is drawn next.
//
// With a target time, pictures in motion have the level that server/live/pace.h chooses, and
// pictures at rest are refined up to the request itself. A refinement is cancelled when another
// request is put. Thread-safe.
#pragma once

#include "plan/request/frame_request.h"
#include "server/base/call.h"
#include "server/live/live_views.h"
#include "server/live/pace.h"

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

namespace clerestory {

struct LivePicture {
    std::shared_ptr<const std::string> bytes;
    std::uint64_t version = 0;  // of the view
    std::uint64_t serial = 0;   // increases with each picture of this drawing
    std::size_t level = 0;      // of the ladder; 0: the request itself
    Level settings = {};        // of that level
    std::uint32_t width = 0, height = 0;
    double milliseconds = 0.0;  // of drawing and encoding; 0 if an earlier picture was equal
    double lightShare = 1.0;    // of its light of surfaces that is computed
};

class LiveDrawing {
public:
    struct Drawn {
        std::string bytes;
        double milliseconds = 0.0;  // as for Pace::measured()
        double lightShare = 1.0;    // as EncodedFrame::lightShare
    };
    // A frame that is wanted. Another request cancels it: a refinement at any time, a frame in
    // motion as long as it has not begun, since poses can come faster than frames.
    struct Order {
        FrameRequest request;
        std::shared_ptr<CancellationToken> cancellation;
        bool isRefinement = false;
    };
    // Throws RequestError.
    using Draw = std::function<Drawn(const Order&)>;
    using Picture = std::shared_ptr<const LivePicture>;

    // One for all streams of the view with equal settings. `view` outlives it.
    static std::shared_ptr<LiveDrawing> of(LiveView& view, const LiveSettings& settings);

    // A picture of the newest request that is newer than `seen`; calls wait for each other and
    // share a picture. `time` replaces that of the request. Throws what `draw` throws for the
    // newest request.
    Picture moved(const Picture& seen, std::optional<double> time, const Draw& draw);

    // A picture of the same request as `seen`, whose level is above 0, with a finer level. Null if
    // another request was put meanwhile. Throws what `draw` throws.
    Picture refined(const Picture& seen, const Draw& draw);

    // A picture of the same request and level as `seen`, whose light was not complete, with the
    // light that is computed now. Null if another request was put meanwhile.
    Picture relit(const Picture& seen, const Draw& draw);

private:
    LiveDrawing(LiveView& view, const LiveSettings& settings) : view_(view), settings_(settings) {}
    // Null if it was cancelled.
    Picture drawnAt(std::size_t level, const FrameRequest& frame, std::uint64_t version,
                    bool isRefinement, const Draw& draw);
    void setPace(const FrameRequest& frame);

    LiveView& view_;
    const LiveSettings settings_;
    std::atomic<std::uint64_t> serial_{0};  // of the last picture
    std::mutex drawing_;
    // With that lock held:
    Picture last_;
    std::string lastText_;  // canonicalText() of its request before scaling
    std::optional<Pace> pace_;
};

}  // namespace clerestory
