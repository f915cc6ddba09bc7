// What the work of jobs asks of the service: traced truths, and frames between those of clients.
#pragma once

#include "comparison/comparison.h"
#include "server/jobs/jobs.h"

namespace clerestory {

class Renderer;
class Service;

// Thrown by drawnBetween() when nobody wants the job any more.
struct JobCancelled {};

// The truth of a frame whose scene has been loaded. Null when `progress` ended it. Throws
// InvalidRequest when the frame names a map that is not there.
std::shared_ptr<const ReferenceRender> tracedReference(Service& service, const FrameRequest& frame,
                                                       ReferenceMode mode, std::uint32_t samples,
                                                       std::uint64_t seed,
                                                       const std::function<bool(double)>& progress);

// On the thread that owns the renderer.
DrawnFrame drawnBy(Renderer& renderer, const FrameRequest& request);

// Waits its turn; frames of clients are drawn between two of these. Throws JobCancelled.
DrawnFrame drawnBetween(Service& service, const FrameRequest& request, const JobControl& control);

}  // namespace clerestory
