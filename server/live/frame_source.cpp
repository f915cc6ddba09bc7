#include "server/live/frame_source.h"

#include "server/base/log.h"

#include <thread>

namespace clerestory {
namespace {

constexpr std::chrono::milliseconds kRetryInterval{100};
constexpr std::chrono::minutes kRetryLimit{2};

}  // namespace

EncodedFrame FrameSource::draw(const FrameRequest& request, bool withPlan,
                               const std::string& requestId, const std::string& client) {
    return draw({.request = request,
                 .withPlan = withPlan,
                 .requestId = requestId,
                 .client = client,
                 .wholeLight = true});
}

EncodedFrame FrameSource::draw(FrameOrder order) {
    const auto begun = Clock::now();
    for (;;) {
        order.arrived = Clock::now();
        try {
            EncodedFrame frame = backend_.draw(order);
            count(200, frame.bytes.size(), order.arrived, order.requestId);
            return frame;
        } catch (const RequestError& error) {
            if (order.cancellation && order.cancellation->cancelled()) throw;
            count(error.problem().status, 0, order.arrived, order.requestId);
            metrics_.refused(error.problem().code);
            const bool again =
                isTemporary(error.problem()) && !stopping_ && Clock::now() - begun < kRetryLimit;
            if (!again) throw;
        }
        std::this_thread::sleep_for(kRetryInterval);
    }
}

// As a request of a client for one frame.
void FrameSource::count(int status, std::size_t bytes, Clock::time_point arrived,
                        const std::string& requestId) {
    metrics_.request("/v1/frames", status);
    logInfo({"POST /v1/frames ", std::to_string(status), " ", std::to_string(bytes), " bytes ",
             fixedPoint(millisecondsSince(arrived), 1), " ms ", requestId});
}

std::shared_ptr<void> StreamSlots::take(const std::string& client) {
    auto held = holdings_.take(Pool::streams, client, 1);
    if (!held) throw RequestError(streamsFull());
    return std::make_shared<Holdings::Held>(*std::move(held));
}

}  // namespace clerestory
