// What mirrors and glass show, one surface for a ray: rays through the triangles of the scene that
// leave each surface as a perfectly smooth one sends them, in double precision.
//
//     const LayerRays layers(scene, pose, plan, surroundings, origin);
//     if (auto met = layers.reflected(ray, seen)) met->point;  // a surface that is mirrored
//
// Does not: split rays, follow lobes, know lines and points.
#pragma once

#include "plan/graph/frame_plan.h"
#include "plan/graph/projection.h"
#include "rays/path.h"
#include "scene/surface_point.h"

#include <optional>

namespace clerestory {

class LayerRays {
public:
    struct Met {
        SurfacePoint point;
        glm::dvec3 place{0.0};   // world
        glm::dvec3 normal{0.0};  // world, unit, on the side that the ray comes from
        bool front = true;       // that is the outer side
        glm::vec3 baseColor{0.0f};
        double length = 0.0;  // of the ray's way from its origin, metres
    };

    // Requires plan.rays. `surroundings` are relative to `origin` (world).
    LayerRays(const Scene& scene, const Pose& pose, const FramePlan& plan,
              const rays::Surroundings& surroundings, const glm::dvec3& origin);

    // The surface that is reflected, or seen through glass, at the point `seen` of a surface along
    // a ray of a pixel; `spread`: slope of the pixel's cone. None: it reflects nothing of the
    // scene, is no glass, or has more than kMaxInterfaces behind it.
    std::optional<Met> reflected(const PixelRay& ray, const SurfacePoint& seen,
                                 double spread) const;
    std::optional<Met> refracted(const PixelRay& ray, const SurfacePoint& seen,
                                 double spread) const;
    // Of an instance.
    Glass glassOf(Index instance) const;

    static constexpr int kMaxInterfaces = 16;  // that a ray crosses

private:
    Met metAt(const PixelRay& ray, const SurfacePoint& seen) const;
    // From `from` on along a unit direction, on the side that it points to.
    std::optional<Met> next(const Met& from, const glm::dvec3& direction, double spread) const;
    // Behind the surface of glass.
    glm::dvec3 beyond(const Met& met, const glm::dvec3& direction) const;

    const Scene& scene_;
    const Pose& pose_;
    const FramePlan& plan_;
    MaterialBindings materials_;
    rays::PathTracer tracer_;
    glm::dvec3 origin_;
};

}  // namespace clerestory
