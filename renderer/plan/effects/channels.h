// Frames of a data channel instead of colour: depth, normals, positions, base colours, labels.
#pragma once

#include "plan/effects/view_context.h"
#include "plan/request/frame_request.h"

#include <span>
#include <vector>

namespace clerestory {

// Sets the value of the channel `through` of every surface from the method that was chosen for it.
// firstMirror: number of mirrored views of earlier views of the frame. Returns it with those of
// this one added.
std::uint32_t labelThrough(SeenView& seen, std::uint32_t firstMirror = 0);

// What a channel shows of each instance of the scene; empty for channels other than materialId and
// classId.
std::vector<std::uint32_t> labelsOf(const Scene& scene, Channel channel,
                                    const FrameRequest& request);

// Sets Draw::label of every surface to that of its instance; nothing without labels.
void labelInstances(SeenView& seen, std::span<const std::uint32_t> labels);

// Sets Draw::label to 1 where the surface reflects the scene, else to 0.
void labelMirrors(SeenView& seen);

// Adds the pass that draws plan.channel of the surfaces in `seen`, the root view `task`.
void planChannel(FramePlan& plan, const ViewTask& task, const SeenView& seen);

// Adds the pass that computes optical flow of plan.layer from the surfaces that planChannel() drew;
// `frame` is the whole frame. Throws InvalidRequest, with pointers below /output/flow, if the other
// camera is wrong.
void planFlow(FramePlan& plan, const FrameContext& context, const Stage& stage,
              const FrameRequest& request, const ViewTask& frame);

// Adds the pass that finds plan.layer of the surfaces that planChannel() drew.
void planLayer(FramePlan& plan, const FrameContext& context, const Stage& stage,
               const FrameRequest& request, const ViewTask& frame);

// Adds the pass that counts the instances in plan.layer of the surfaces that planChannel() drew.
void planLayerInstances(FramePlan& plan, const FrameContext& context, const Stage& stage,
                        const ViewTask& frame);

// Adds the pass that measures the instances whose identifiers planChannel() drew. Throws
// InvalidRequest for lenses that no projection matrix describes.
void planInstances(FramePlan& plan, const Stage& stage, const ViewTask& frame);

}  // namespace clerestory
