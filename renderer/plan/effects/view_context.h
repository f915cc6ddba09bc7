// A frame is a tree of views. The root is the requested camera; flat mirrors and captured cubes
// that a view shows may need child views. planView() adds the passes of one view, after those of
// its children. Pure.
//
// Each effect is a file in effects/ with free functions of a ViewContext and a ViewTask, which
// choose a method for each surface in the view and add its passes.
#pragma once

#include "plan/cost/cost.h"
#include "plan/graph/frame_context.h"
#include "plan/graph/plan_builder.h"
#include "plan/visibility/draws.h"
#include "plan/visibility/enclosure.h"
#include "plan/visibility/occlusion.h"

#include <map>
#include <optional>

namespace clerestory {

// State that all views of a frame share.
struct ViewContext {
    // The arguments must outlive this object.
    ViewContext(const FrameContext& frame, const Stage& stage, PlanBuilder& builder);

    const FrameContext& frame;
    const Stage& stage;
    PlanBuilder& builder;

    std::vector<bool> moves;  // one for each instance; empty if none moves
    Bounds sceneBounds;       // world, over all times
    std::uint64_t sceneTriangles = 0;
    Shading shading;  // mean over surfaces
    std::size_t curvedReflectors = 0;
    std::vector<Occluder> occluders;          // of the root view
    std::optional<BoxHierarchy> opaqueBoxes;  // see enclosureAt(); made on first use
    std::map<std::string, Method> agreed;     // see agreedMethods()
};

// A view to plan, and the target of its picture.
struct ViewTask {
    DrawScene::Purpose purpose = DrawScene::Purpose::surface;
    Subject subject;
    Effect effect = Effect::base;
    std::string reason;
    View view;
    std::uint32_t width = 0, height = 0;  // pixels
    TargetId target = kNoTarget;
    std::uint32_t face = 0;             // of a cube target
    std::uint32_t generation = 0;       // 0: the root
    double part = 1.0;                  // of the frame that this root view shows, 0..1
    double weight = 1.0;                // of the view in the frame, 0..1; see kMinWeight
    bool captured = false;              // face of a captured cube, or mirrored view in one
    std::uint32_t mirrorsLeft = 0;      // nested mirrored views that may still be added
    std::uint32_t probeGeneration = 0;  // of the captured cubes that this view shows; 0: none
    OwnBackground background;           // of the requested view
    std::vector<std::size_t> hidden;    // omitted surfaces, indices of Stage::surfaces; sorted
};

// Adds the passes of the view and of its children. Returns the surfaces that it shows.
SeenView planView(ViewContext& context, const ViewTask& task);

}  // namespace clerestory
