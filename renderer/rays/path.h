// One ray of a pixel and its path through the scene, with the same formulae as the shaders: the
// includes of shaders/ are compiled as C++.
//
//     const PathTracer tracer(surroundings);
//     const Path path = tracer.follow(rayOf(start, way), Ray::mirrored, {.paths = 4});
//
// Pure: the same arguments give the same bytes. Threads may share a tracer.
#pragma once

#include "rays/hits.h"
#include "rays/record.h"
#include "rays/surroundings.h"
#include "rays/triangle_tree.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

namespace clerestory::rays {

inline constexpr float kNoLimit = 1e30f;  // metres

// A record, decoded, and its direction alone.
RecordedRay rayOf(const Start& start, const Way& way);
glm::vec3 directionOf(const Way& way);

struct Path {
    float radiance[3];       // mean of the paths of a lobe
    std::uint32_t surfaces;  // hash of those that were met; 0: there is no ray
    float distance;          // to what is met first, metres: a harmonic mean; of a ray into a body,
                             // length of the path
    std::uint32_t count;     // of paths

    // Whether a single ray met nothing at all.
    bool open() const;
};

class PathTracer {
public:
    // The members of `surroundings` must outlive this object.
    explicit PathTracer(const Surroundings& surroundings);
    ~PathTracer();

    // Weights of the directions of a lobe add up to one, so that a uniform environment stays as it
    // is.
    Path follow(const RecordedRay& ray, Ray kind, const Lobe& lobe) const;
    // The same for several rays, with less time waiting for memory. paths: one for each.
    void follow(std::span<const RayWithLobe> rays, Ray kind, std::span<Path> paths) const;

    // That of a ray that leaves the scene at once, if it is known to: no path is followed.
    Path open(const RecordedRay& ray, Ray kind) const;

    // start: world axes, relative to the tree's origin. along: unit, eye space's axes. width,
    // spread: of the cone that the ray represents, metres at its start and slope. Glass does not
    // refract. limit: metres; what is farther away is not met. first: the nearest hit, if it is
    // known.
    SurfaceHit surfaceAlong(const glm::vec3& start, const glm::vec3& along, float width,
                            float spread, float limit = kNoLimit,
                            const TriangleHit* first = nullptr) const;
    // Arguments as surfaceAlong().
    std::optional<PointHit> pointAlong(const glm::vec3& start, const glm::vec3& along, float width,
                                       float spread) const;
    // The surface that a ray at normal incidence hits at the middle of a triangle of the tree,
    // averaged over the triangle. Nothing if rays may pass it: holes, blended surfaces, glass.
    std::optional<SurfaceHit> middleOf(std::uint32_t triangle) const;

private:
    struct Scene;
    std::unique_ptr<Scene> scene_;
};

}  // namespace clerestory::rays
