// What mirrors and glass show, one surface for a ray: rays through the triangles of the scene that
// leave each surface as a perfectly smooth one with its normal map sends them, in double precision.
//
//     const LayerRays layers(scene, pose, plan, surroundings, origin);
//     const LayerRays::PixelView pixel{ray, seen, spread};
//     if (auto shown = layers.shown(OutputLayer::reflected, pixel)) shown->met.point;
//
// Does not: split rays, follow lobes, know lines and points.
#pragma once

#include "plan/graph/frame_plan.h"
#include "plan/graph/projection.h"
#include "rays/path.h"
#include "scene/surface_point.h"

#include <optional>
#include <vector>

namespace clerestory {

class LayerRays {
public:
    struct Met {
        SurfacePoint point;
        glm::dvec3 position{0.0};  // world
        glm::dvec3 normal{
            0.0};  // of the geometry: world, unit, on the side that the ray comes from
        glm::dvec3 bumped{0.0};  // the same with the bumps of a normal map
        bool front = true;       // that is the outer side
        glm::vec3 baseColor{0.0f};
        double length = 0.0;  // of the ray's way from its origin, metres
    };
    // The surface that a ray of a pixel meets first. spread: slope of the pixel's cone.
    struct PixelView {
        PixelRay ray;
        SurfacePoint seen;
        double spread = 0.0;
    };
    // A surface, and the faces of mirrors or glass that turn the ray before.
    struct Shown {
        Met met;
        std::uint32_t faces = 1;
    };
    // The way of a ray after the last face that turns it.
    struct Line {
        glm::dvec3 start{0.0}, direction{0.0};  // world; unit
        double length = 0.0;                    // of the way to the start, metres
    };

    // Requires plan.rays. `surroundings` are relative to `origin` (world).
    LayerRays(const Scene& scene, const Pose& pose, const FramePlan& plan,
              const rays::Surroundings& surroundings, const glm::dvec3& origin);

    // What the surface of the pixel, a mirror or glass, reflects or lets through. None: nothing of
    // the scene, it is no glass, or more than kMaxFaces are before it. layer: not direct.
    std::optional<Shown> shown(OutputLayer layer, const PixelView& pixel) const;
    // The instance of shown(), then those that would take its place if all before them were absent
    // but for glass in the layer refracted; each once.
    void instancesAlong(OutputLayer layer, const PixelView& pixel,
                        std::vector<Index>& instances) const;
    // The way of a ray that is turned by as many faces as in Shown, the first of them that of the
    // pixel, or one of `first`. Surfaces that do not turn it are absent. None: there are fewer.
    std::optional<Line> lineAfter(OutputLayer layer, const PixelView& pixel,
                                  std::uint32_t faces) const;
    std::optional<Line> lineAfter(OutputLayer layer, const PixelRay& ray, double spread,
                                  Index first, std::uint32_t faces) const;
    // Of an instance.
    Glass glassOf(Index instance) const;

    static constexpr std::uint32_t kMaxFaces = 16;  // that turn a ray
    static constexpr std::uint32_t kMaxSurfaces =
        256;  // that instancesAlong() and lineAfter() pass

private:
    Met metAt(const PixelView& pixel) const;
    // From `from` on along a unit direction, on the side that it points to.
    std::optional<Met> next(const Met& from, const glm::dvec3& direction, double spread) const;
    // The way after `faces` faces, the first of which is `here`.
    std::optional<Line> lineFrom(OutputLayer layer, Met here, glm::dvec3 direction, double spread,
                                 std::uint32_t faces) const;
    // The direction after a face.
    glm::dvec3 turned(OutputLayer layer, const Met& met, const glm::dvec3& direction) const;
    glm::dvec3 throughGlass(const Met& met, const glm::dvec3& direction) const;
    glm::dvec3 relative(const glm::dvec3& position) const { return position - origin_; }
    bool hasBumps(Index instance) const;
    const Material& materialOf(Index instance) const;

    const Scene& scene_;
    const Pose& pose_;
    const FramePlan& plan_;
    MaterialBindings materials_;
    rays::PathTracer tracer_;
    glm::dvec3 origin_;
};

}  // namespace clerestory
