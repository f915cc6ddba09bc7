// Frames that the server draws for sequences and live streams. They wait in the same queue as the
// frames of clients, and are repeated while the renderer is busy. Thread-safe.
#pragma once

#include "server/api/backend.h"
#include "server/api/request_metrics.h"
#include "server/base/holdings.h"

#include <atomic>
#include <cstddef>
#include <memory>
#include <string>

namespace clerestory {

class FrameSource {
public:
    // `stopping`: the server ends, and nothing is repeated. All of them must outlive this.
    // `renderers`: how many frames can be drawn at the same time.
    FrameSource(RenderBackend& backend, RequestMetrics& metrics, const std::atomic<bool>& stopping,
                std::size_t renderers)
        : backend_(backend), metrics_(metrics), stopping_(stopping), renderers_(renderers) {}

    // A frame with complete light of surfaces, for sequences.
    // Repeats the request for up to two minutes while the problem is temporary: the queue is full,
    // the scene is loading, a budget is being measured. Throws RequestError.
    EncodedFrame draw(const FrameRequest& request, bool withPlan, const std::string& requestId,
                      const std::string& client);

    // The same with the time of each attempt as FrameOrder::arrived. A cancelled frame is not
    // repeated and counts as no request.
    EncodedFrame draw(FrameOrder order);

    bool stopping() const { return stopping_; }
    std::size_t renderers() const { return renderers_; }

private:
    void count(int status, std::size_t bytes, Clock::time_point arrived,
               const std::string& requestId);

    RenderBackend& backend_;
    RequestMetrics& metrics_;
    const std::atomic<bool>& stopping_;
    const std::size_t renderers_;
};

// Limits how many streams and sequences run at once, of all clients and of each: each occupies a
// thread. Thread-safe.
class StreamSlots {
public:
    explicit StreamSlots(Holdings& holdings) : holdings_(holdings) {}

    // Occupied as long as the result exists. Throws RequestError 503 if there is no free slot, or
    // the client has its share.
    std::shared_ptr<void> take(const std::string& client);

private:
    Holdings& holdings_;
};

}  // namespace clerestory
