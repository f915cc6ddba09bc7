// One client's stream of a live view: motion JPEG, one part for each picture.
#pragma once

#include "server/base/call.h"
#include "server/live/frame_source.h"
#include "server/live/live_drawing.h"
#include "server/live/live_views.h"

#include <memory>
#include <string>

namespace clerestory {

struct StreamRequest {
    std::shared_ptr<LiveView> view;
    double rate = 15.0;     // the most frames per second
    bool play = false;      // the time of the frames is the clock's
    double targetMs = 0.0;  // of a frame in motion; 0: every frame is the request itself
};

class LiveStream {
public:
    // `slot` is held as long as this exists; `frames` outlives this.
    LiveStream(FrameSource& frames, std::shared_ptr<void> slot, StreamRequest request,
               std::string requestId, std::string client);

    // Draws the present frame. Throws RequestError.
    void draw();

    // Sends pictures until the server stops or the client closes its side. Returns false.
    bool run(const Sink& sink);

private:
    LiveDrawing::Draw drawer();
    void drawOrKeep();
    bool mayRefine() const;
    bool mayRelight() const;
    bool relight();
    bool refine();
    bool send(const Sink& sink);

    FrameSource& frames_;
    std::shared_ptr<void> slot_;
    StreamRequest request_;
    std::string requestId_, client_;
    std::shared_ptr<LiveDrawing> drawing_;
    LiveDrawing::Picture picture_;
    std::uint64_t version_ = 0;       // of the view, that was drawn or could not be drawn
    bool repeated_ = false;           // the last picture was sent a second time
    bool cannotRefine_ = false;       // the last picture
    bool delimiterSent_ = false;      // the one before the next part
    Clock::time_point begun_, sent_;  // the last picture
    Clock::time_point lit_;           // when more light was requested
};

}  // namespace clerestory
