#include "plan/effects/view_context.h"

#include "plan/visibility/lighting.h"

#include <algorithm>

namespace clerestory {
namespace {

// Enough for a mean; a scene may have many thousands.
constexpr std::size_t kSampledSurfaces = 64;

double texturesOf(const Material& m) {
    return static_cast<double>(m.baseColorTexture.present()) +
           static_cast<double>(m.metallicRoughnessTexture.present()) +
           static_cast<double>(m.normalTexture.present()) +
           static_cast<double>(m.occlusionTexture.present()) +
           static_cast<double>(m.emissiveTexture.present());
}

Shading meanShading(const Stage& stage) {
    const std::size_t count = stage.surfaces.size();
    const std::size_t step = std::max<std::size_t>(count / kSampledSurfaces, 1);
    Shading sum;
    double weights = 0.0;
    for (std::size_t i = 0; i < count; i += step) {
        const Surface& surface = stage.surfaces[i];
        const Instance& instance = stage.scene.instances[surface.instance];
        glm::dmat4 fromNode = stage.pose.worldFromNode[instance.node];
        const glm::dvec3 origin(fromNode[3]);
        fromNode[3] = {0.0, 0.0, 0.0, 1.0};
        const Bounds box =
            transformed(boundsOf(stage.pose, stage.scene.meshes[instance.mesh]), fromNode);
        std::uint32_t reaching = 0;
        sum.lights += lightsReaching(stage.lights, origin, box, reaching).count;
        sum.textures += texturesOf(stage.material(surface));
        sum.glass += surface.glass != Glass::none ? 1.0 : 0.0;
        weights += 1.0;
    }
    if (weights > 0.0) {
        sum.lights /= weights;
        sum.textures /= weights;
        sum.glass /= weights;
    }
    sum.shadows = stage.settings.effects.shadows;
    sum.surfaceLight = stage.settings.effects.indirectLight;
    return sum;
}

}  // namespace

ViewContext::ViewContext(const FrameContext& frame, const Stage& stage, PlanBuilder& builder)
    : frame(frame),
      stage(stage),
      builder(builder),
      moves(stage.scene.clips.empty() ? std::vector<bool>{} : instancesThatChange(stage.scene)),
      sceneBounds(lastingBounds(stage.scene, stage.pose)),
      sceneTriangles(triangleCount(stage.scene)),
      shading(meanShading(stage)),
      curvedReflectors(static_cast<std::size_t>(
          std::count_if(stage.surfaces.begin(), stage.surfaces.end(),
                        [](const Surface& s) { return s.reflector == Reflector::curved; }))) {}

}  // namespace clerestory
