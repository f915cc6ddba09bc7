// What long jobs do again and again: trace a reference, and draw frames in turn with clients.
#pragma once

#include "comparison/comparison.h"
#include "server/jobs/jobs.h"
#include "server/queue/render_queue.h"
#include "server/scenes/scene_library.h"

namespace clerestory {

// What jobs use; the references must outlive them.
struct JobResources {
    RenderQueue& queue;
    SceneLibrary& library;
    // Everything that can change a byte of the request's frame, as text.
    std::function<std::string(const Scene&, const FrameRequest&)> contentText;
};

// Thrown by drawInQueue() when the job is cancelled.
struct JobCancelled {};

// The path-traced reference of a frame whose scene was loaded. Null if `progress` returned false.
// Throws InvalidRequest if the frame names an environment map that is not loaded.
std::shared_ptr<const ReferenceRender> traceReference(SceneLibrary& library,
                                                      const FrameRequest& frame, ReferenceMode mode,
                                                      std::uint32_t samples, std::uint64_t seed,
                                                      const std::function<bool(double)>& progress);

// On the thread that owns the renderer.
DrawnFrame drawTimed(Renderer& renderer, const FrameRequest& request);

// Waits for its turn in the queue, where clients' frames can come between two frames of a job.
// Throws JobCancelled.
DrawnFrame drawInQueue(const JobResources& resources, const FrameRequest& request,
                       const JobControl& control);

}  // namespace clerestory
