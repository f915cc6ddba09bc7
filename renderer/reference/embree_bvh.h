// Embree's acceleration structure over triangles.
//
//     const EmbreeBvh bvh(triangles.size(), cornersOf, accepts);
//     if (const std::optional<Hit> hit = bvh.intersect(ray)) ...
#pragma once

#include "rays/embree.h"
#include "reference/ray.h"

#include <array>
#include <cstdint>
#include <functional>
#include <optional>

namespace clerestory::reference {

class EmbreeBvh {
public:
    using Corners = std::array<glm::vec3, 3>;
    // Whether a ray hits the triangle at this point; weights: barycentric, of the second and third
    // corner; counterClockwise: as the ray's origin sees the corners.
    using HitFilter = std::function<bool(std::uint32_t triangle, double weightB, double weightC,
                                         bool counterClockwise)>;

    // cornersOf(i): of triangle i, below `triangles`; called by the constructor only. Throws
    // std::runtime_error if Embree fails.
    EmbreeBvh(std::size_t triangles, const std::function<Corners(std::uint32_t)>& cornersOf,
              HitFilter accepts);
    ~EmbreeBvh();
    EmbreeBvh(const EmbreeBvh&) = delete;
    EmbreeBvh& operator=(const EmbreeBvh&) = delete;

    // The nearest accepted hit, and whether there is any. Rays that are not finite hit nothing.
    std::optional<Hit> intersect(const Ray& ray) const;
    bool occluded(const Ray& ray) const;

private:
    HitFilter accepts_;
    RTCDevice device_ = nullptr;
    RTCScene scene_ = nullptr;
};

}  // namespace clerestory::reference
