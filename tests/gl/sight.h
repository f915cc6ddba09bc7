// Intersections of lines of sight in double precision, to compare effects with.
#pragma once

#include "support.h"

#include "plan/visibility/view.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace clerestory::test {

struct Ray {
    glm::dvec3 origin{0.0}, direction{0.0, 0.0, -1.0};  // unit
};

// Through the point (x, y) of the picture, in pixels from its upper left corner. For cameras given
// by position, target and yfov.
inline Ray sight(const FrameRequest& r, double x, double y) {
    const glm::dvec3 up = r.camera.up.value_or(glm::dvec3(0.0, 1.0, 0.0));
    const glm::dmat3 worldFromView(worldFromLookAt(*r.camera.position, *r.camera.target, up));
    const double slope = std::tan(0.5 * *r.camera.yfov);
    const double aspect = double(r.width) / r.height;
    const glm::dvec3 seen((2.0 * x / r.width - 1.0) * slope * aspect,
                          (1.0 - 2.0 * y / r.height) * slope, -1.0);
    return {*r.camera.position, worldFromView * glm::normalize(seen)};
}
inline Ray sightOfPixel(const FrameRequest& r, std::uint32_t x, std::uint32_t y) {
    return sight(r, x + 0.5, y + 0.5);
}

// Distance to where the ray enters the ball.
inline std::optional<double> meetsBall(const Ray& ray, const glm::dvec3& center, double radius) {
    const glm::dvec3 toCenter = center - ray.origin;
    const double along = glm::dot(toCenter, ray.direction);
    const double inside = radius * radius - glm::dot(toCenter, toCenter) + along * along;
    if (along <= 0.0 || inside <= 0.0) return std::nullopt;
    return along - std::sqrt(inside);
}

// The exit point of a ray that starts inside the box.
inline glm::dvec3 leavesBox(const Ray& ray, const glm::dvec3& low, const glm::dvec3& high) {
    double nearest = 1e300;
    for (int i = 0; i < 3; ++i) {
        if (ray.direction[i] == 0.0) continue;
        const double wall = ray.direction[i] > 0.0 ? high[i] : low[i];
        nearest = std::min(nearest, (wall - ray.origin[i]) / ray.direction[i]);
    }
    return ray.origin + nearest * ray.direction;
}

inline double greatestDifference(const glm::vec3& a, const glm::vec3& b) {
    const glm::vec3 d = glm::abs(a - b);
    return std::max({d.x, d.y, d.z});
}

// Statistics over all pixels of two images of one size.
inline double greatestDifference(const Image& a, const Image& b) {
    double greatest = 0.0;
    for (std::uint32_t y = 0; y < a.height; ++y) {
        for (std::uint32_t x = 0; x < a.width; ++x) {
            greatest = std::max(greatest, greatestDifference(color(a, x, y), color(b, x, y)));
        }
    }
    return greatest;
}

// Samples that are not finite, or negative.
inline std::uint64_t badSamples(const Image& image) {
    std::uint64_t bad = 0;
    for (std::size_t i = 0; i < std::size_t{image.width} * image.height * image.channels; ++i) {
        bad += !(image.floats()[i] >= 0.0f && std::isfinite(image.floats()[i]));
    }
    return bad;
}

}  // namespace clerestory::test
