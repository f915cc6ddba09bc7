// The triangles of a posed scene in an Embree hierarchy, for rays on the processor. Hits are those
// of shaders/include/trace.glsl over the same triangles (tests/gl/trace_test.cpp).
#pragma once

#include "rays/embree.h"
#include "scene/bvh.h"

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace clerestory::rays {

struct TriangleHit {
    float distance;
    std::uint32_t triangle;  // as triangle() takes it
    float u, v;              // weights of the second and third corner
};

// Single-sided triangles are hit from the front only (BvhTriangle::side). All coordinates are
// relative to one origin, so that distance from the world's origin costs no precision. Built by one
// thread: of coincident triangles the same one is hit in every process.
class TriangleTree {
public:
    TriangleTree();
    ~TriangleTree();
    TriangleTree(const TriangleTree&) = delete;
    TriangleTree& operator=(const TriangleTree&) = delete;

    // The part that stays, and the part that is rebuilt for other poses (in lower quality, faster).
    // Throw std::runtime_error if Embree fails.
    void setStill(std::vector<BvhTriangle> triangles);
    void setMoving(std::vector<BvhTriangle> triangles);

    // An index counts the triangles of both parts, the still ones first.
    const BvhTriangle& triangle(std::uint32_t index) const {
        return index < still_.triangles.size() ? still_.triangles[index]
                                               : moving_.triangles[index - still_.triangles.size()];
    }
    std::size_t stillTriangles() const { return still_.triangles.size(); }
    std::uint64_t bytes() const;

    // The nearest hit with a distance in (0, 1e30). direction: unit. Returns false if there is
    // none, and for directions and origins that are not finite. Threads may call it at the same
    // time.
    bool nearestHit(const float origin[3], const float direction[3], TriangleHit& hit) const;

private:
    struct Part {
        std::vector<BvhTriangle> triangles;    // by side
        std::array<std::uint32_t, 3> first{};  // triangle of each geometry
        RTCScene scene = nullptr;
    };
    void build(Part& part, std::vector<BvhTriangle> triangles, RTCBuildQuality quality);

    RTCDevice device_ = nullptr;
    Part still_, moving_;
};

}  // namespace clerestory::rays
