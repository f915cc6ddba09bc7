// A frame is a tree of views: the root is the client's camera, and a mirror, a curved reflector or
// a piece of glass that a view shows may need a child view. planView() adds the passes of one view
// and, before them, those of its children. Pure.
//
// Each effect is a file of effects/ with free functions over a ViewContext and a ViewTask; they
// decide what its surfaces show in this view and add the passes for it.
#pragma once

#include "plan/graph/frame_context.h"
#include "plan/graph/plan_builder.h"
#include "plan/visibility/draws.h"
#include "plan/visibility/occlusion.h"

namespace clerestory {

// What all views of a frame share.
struct ViewContext {
    // The arguments must outlive the context.
    ViewContext(const FrameContext& frame, const Stage& stage, PlanBuilder& builder);

    const FrameContext& frame;
    const Stage& stage;
    PlanBuilder& builder;

    std::vector<bool> moves;  // of each instance; empty when nothing does
    Bounds sceneBounds;       // world, at any time
    std::uint64_t sceneTriangles = 0;
    std::vector<Wall> walls;          // of the root view
    std::vector<Bounds> opaqueBoxes;  // of all clusters, relative to the root's eye; on first use
};

// One view to plan, and the target of its picture.
struct ViewTask {
    DrawScene::Purpose purpose = DrawScene::Purpose::surface;
    std::string name = "surface";
    Effect effect = Effect::base;
    std::string reason;
    View view;
    std::uint32_t width = 0, height = 0;  // pixels
    TargetId target = kNoTarget;
    std::uint32_t face = 0;             // of a cube target
    std::uint32_t generation = 0;       // 0: the root
    double weight = 1.0;                // of the view in the frame; see kMinWeight
    bool captured = false;              // a face of a captured cube, or a mirrored view in one
    std::uint32_t mirrorsLeft = 0;      // nested mirrored views that may still be added
    std::uint32_t probeGeneration = 0;  // of the captured cubes that this view shows; 0: none
    std::vector<std::size_t> hidden;    // surfaces of the stage that the view omits; sorted
};

// Adds the passes of the view and of its children. Returns what it shows.
SeenView planView(ViewContext& context, const ViewTask& task);

}  // namespace clerestory
