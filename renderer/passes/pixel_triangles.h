// Triangles of a scene in the pixels of a picture of it. Places are in pixels from the lower left
// corner of the picture, depths in metres from the plane of the eye.
//
//     const PixelTriangles triangles(scene, pose, view, instance, width, height);
//     const auto found = triangles.at(firstIndex);
//     if (const auto* seen = std::get_if<PixelTriangles::Seen>(&found)) {
//         seen->triangle.eachPixel(width, height, [&](std::uint32_t x, std::uint32_t y) {
//             covered[{x, y}] += seen->triangle.shareOf({x, y});
//         });
//     }
#pragma once

#include "plan/graph/draw.h"
#include "scene/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <variant>

namespace clerestory {

struct PixelTriangle {
    struct Corner {
        glm::dvec2 position{0.0};
        float depth = 0.0f;
    };
    std::array<Corner, 3> corners;  // counter-clockwise

    double area() const;                     // pixels
    double innerRadius() const;              // of the largest circle in it, pixels
    std::pair<float, float> depths() const;  // the least and the greatest one
    // Along the longest edge: a triangle that is narrower than a pixel has no slope to extend.
    float depthAt(const glm::dvec2& position) const;
    bool contains(const glm::dvec2& position) const;
    // Of the pixel with that lower left corner: the fraction that the triangle covers.
    double shareOf(const glm::dvec2& pixel) const;
    // Of 64 places in the pixel with that lower left corner, the same in all pixels: those in the
    // triangle.
    std::uint64_t placesIn(const glm::dvec2& pixel) const;

    // use(x, y): of each pixel of the picture that the triangle may be in.
    template <class Use>
    void eachPixel(std::uint32_t width, std::uint32_t height, const Use& use) const {
        const auto [bottom, top] =
            std::minmax({corners[0].position.y, corners[1].position.y, corners[2].position.y});
        for (double y = std::max(std::floor(bottom), 0.0); y < std::min<double>(top, height); ++y) {
            const auto [left, right] = columnsBetween(y, y + 1.0);
            for (double x = std::max(std::floor(left), 0.0); x < std::min<double>(right, width);
                 ++x) {
                use(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y));
            }
        }
    }

private:
    // The columns of the part of the triangle between two rows.
    std::pair<double, double> columnsBetween(double low, double high) const;
    std::size_t longest() const;  // the corner that it begins at
};

// The triangles of an instance.
class PixelTriangles {
public:
    PixelTriangles(const Scene& scene, const Pose& pose, const View& view, std::uint32_t instance,
                   std::uint32_t width, std::uint32_t height);

    struct Seen {
        PixelTriangle triangle;
        bool facesEye = true;
    };
    // Why it is not seen: it reaches behind the near plane; or its area is zero, or it reaches
    // behind the view's clip plane.
    enum class Absent { behindEye, notSeen };
    // The one that begins at that index of Scene::indices.
    std::variant<Seen, Absent> at(std::uint32_t firstIndex) const;

private:
    const Scene& scene_;
    const MeshVertices vertices_;
    const std::optional<glm::dvec4> clipPlane_;
    const glm::dmat4 eyeFromMesh_, viewFromEye_, clipFromView_;
    const glm::dvec2 size_;
    const bool clockwiseIsFront_;
};

// The depth for a number of a depth buffer, 0..1; a great number for the far end.
float depthOf(const View& view, float stored);

}  // namespace clerestory
