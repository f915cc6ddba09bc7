// Points that move with a surface: a triangle, line or point of an instance, and weights of its
// corners. Node transforms, skins and morph targets move them with the pose.
//
//     const SurfacePoint seen = pointAlong(scene, pose, instance, firstIndex, eye, direction);
//     positionOf(scene, later, seen) - positionOf(scene, pose, seen);  // metres
#pragma once

#include "scene/scene.h"

namespace clerestory {

struct SurfacePoint {
    Index instance = 0;
    std::uint32_t firstIndex = 0;       // into Scene::indices: of the primitive
    glm::dvec3 weights{1.0, 0.0, 0.0};  // of its corners, not negative, their sum is 1
};

// World, metres.
glm::dvec3 positionOf(const Scene& scene, const Pose& pose, const SurfacePoint& point);

// Of the interpolated vertex normals: world, unit, on the outer side. Of the triangle where they
// vanish.
glm::dvec3 normalOf(const Scene& scene, const Pose& pose, const SurfacePoint& point);

// Where a ray meets the plane of a triangle, or the point of the triangle that is close to there;
// of a line, the point that is nearest to the ray. World; direction: any length but 0.
SurfacePoint pointAlong(const Scene& scene, const Pose& pose, Index instance,
                        std::uint32_t firstIndex, const glm::dvec3& origin,
                        const glm::dvec3& direction);

}  // namespace clerestory
