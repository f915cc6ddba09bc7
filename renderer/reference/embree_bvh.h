// Embree's acceleration structure over the triangles of a SceneGeometry.
#pragma once

#include "rays/embree.h"
#include "reference/scene_geometry.h"

namespace clerestory::reference {

struct SceneGeometry::Bvh {
    // Throws std::runtime_error if Embree fails.
    explicit Bvh(const SceneGeometry& geometry);
    ~Bvh();
    Bvh(const Bvh&) = delete;
    Bvh& operator=(const Bvh&) = delete;

    std::optional<Hit> intersect(const Ray& ray) const;
    bool occluded(const Ray& ray) const;

private:
    const SceneGeometry& geometry_;
    RTCDevice device_ = nullptr;
    RTCScene scene_ = nullptr;
};

}  // namespace clerestory::reference
