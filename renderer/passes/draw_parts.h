// Divides draws into parts that a software driver finishes in about a second, so that a frame can
// be abandoned between them. A draw is one call of the driver, which may fill the picture thousands
// of times.
//
//     DrawParts parts(scene, pose, view, pixels);
//     for (const DrawParts::Part& part : parts.of(draw)) { ... }
//
// Fragments are estimated from above: where triangles may be large, by their rectangles in the
// picture, elsewhere by the area of clusters and their distance.
#pragma once

#include "plan/graph/draw.h"
#include "scene/scene.h"

#include <cstdint>
#include <span>
#include <vector>

namespace clerestory {

// Areas of Scene::clusters, square metres in mesh space, at rest; 0 for lines and points.
std::vector<float> clusterAreas(const Scene& scene);

class DrawParts {
public:
    struct Part {
        std::uint32_t firstIndex = 0, indexCount = 0;  // as those of a Draw
        double fragments = 0.0;
    };
    static constexpr double kMaxFragments = 16e6;  // of a part, unless it is a single triangle

    // areas: clusterAreas(scene). pixels: of the target. The arguments must outlive this object.
    DrawParts(const Scene& scene, std::span<const float> areas, const Pose& pose, const View& view,
              double pixels);

    // Valid until the next call.
    std::span<const Part> of(const Draw& draw);

private:
    double shareOf(std::size_t cluster, const glm::dmat4& toEye, double scale) const;
    void append(std::uint32_t firstIndex, std::uint32_t indexCount, double fragments);
    void appendTriangles(const Draw& draw, std::uint32_t firstIndex, std::uint32_t end);
    void appendClusters(const Draw& draw);

    const Scene& scene_;
    std::span<const float> areas_;
    const Pose& pose_;
    const View& view_;
    double pixels_;
    double perArea_;  // share of the picture of a square metre that faces the eye at one metre
    std::vector<Part> parts_;
};

}  // namespace clerestory
