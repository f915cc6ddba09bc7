// Checks that the renderer still draws correctly: a tiny frame with a known result.
#pragma once

#include "server/queue/render_queue.h"

#include <atomic>

namespace clerestory {

class Canary {
public:
    // Adds its scene to the renderer. `queue` must outlive this.
    explicit Canary(RenderQueue& queue);

    // Draws the frame, unless a frame was drawn, or a shader compiled, in the last seconds. Throws
    // RequestError 503 if the frame fails or is wrong. Thread-safe.
    void check();
    // A client's frame was drawn: check() needs no frame for some seconds.
    void frameWasDrawn();

private:
    RenderQueue& queue_;
    std::atomic<std::int64_t> lastDrawn_{0};  // milliseconds of Clock; 0: never
};

}  // namespace clerestory
