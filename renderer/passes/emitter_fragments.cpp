#include "passes/emitter_fragments.h"

#include "passes/pixel_triangles.h"

namespace clerestory {
namespace {

// Radius of the largest circle in a triangle, pixels: with more the circle holds a whole pixel.
constexpr double kLargeRadius = 0.75;

// Those that are seen; none if one of them is large.
std::vector<PixelTriangle> trianglesOf(const PixelTriangles& all,
                                       const EmitterCoverage::Emitter& emitter) {
    std::vector<PixelTriangle> triangles;
    for (std::uint32_t i = 0; i + 2 < emitter.indexCount; i += 3) {
        const auto found = all.at(emitter.firstIndex + i);
        if (const auto* absent = std::get_if<PixelTriangles::Absent>(&found)) {
            if (*absent == PixelTriangles::Absent::behindEye) return {};
            continue;
        }
        const auto& seen = std::get<PixelTriangles::Seen>(found);
        if (!seen.facesEye && !emitter.doubleSided) continue;
        if (!(seen.triangle.innerRadius() <= kLargeRadius)) return {};
        triangles.push_back(seen.triangle);
    }
    return triangles;
}

}  // namespace

std::vector<EmitterFragment> emitterFragments(const Scene& scene, const Pose& pose,
                                              const EmitterCoverage& work, std::uint32_t width,
                                              std::uint32_t height) {
    std::vector<EmitterFragment> fragments;
    for (std::uint32_t e = 0; e < work.emitters.size(); ++e) {
        const EmitterCoverage::Emitter& emitter = work.emitters[e];
        const PixelTriangles all(scene, pose, work.view, emitter.instance, width, height);
        for (const PixelTriangle& triangle : trianglesOf(all, emitter)) {
            if (fragments.size() == kMaxFragments) return fragments;
            const auto [nearest, farthest] = triangle.depths();
            triangle.eachPixel(width, height, [&](std::uint32_t x, std::uint32_t y) {
                if (fragments.size() == kMaxFragments) return;
                const glm::dvec2 corner(x, y), center = corner + 0.5;
                const auto share = static_cast<float>(triangle.shareOf(corner));
                if (share == 0.0f) return;
                fragments.push_back({.x = x,
                                     .y = y,
                                     .share = share,
                                     .places = triangle.placesIn(corner),
                                     .hasCenter = triangle.contains(center),
                                     .emitter = e,
                                     .depth = triangle.depthAt(center),
                                     .depthRange = farthest - nearest});
            });
        }
    }
    return fragments;
}

}  // namespace clerestory
