#include "plan/effects/view_context.h"

namespace clerestory {

ViewContext::ViewContext(const FrameContext& frame, const Stage& stage, PlanBuilder& builder)
    : frame(frame),
      stage(stage),
      builder(builder),
      moves(stage.scene.clips.empty() ? std::vector<bool>{} : instancesThatMove(stage.scene)),
      sceneBounds(lastingBounds(stage.scene, stage.pose)),
      sceneTriangles(triangleCount(stage.scene)) {}

}  // namespace clerestory
