#include "light/edge_lengths.h"

#include <algorithm>

namespace clerestory::light {
namespace {

// Growth of the length with the distance from the body, in units of the length at the body.
constexpr double kGrowth = 5.0;

// The distance of a box from the one between two corners; 0 where they overlap.
double distanceOf(const Bounds& box, const glm::dvec3& low, const glm::dvec3& high) {
    const glm::dvec3 apart = glm::max(glm::dvec3(box.min) - high, low - glm::dvec3(box.max));
    return glm::length(glm::max(apart, glm::dvec3(0.0)));
}

}  // namespace

double EdgeLengths::at(const glm::dvec3& world, std::uint32_t except) const {
    double length = common;
    for (const Body& body : small) {
        if (body.instance == except) continue;
        const double away = distanceOf(body.box, world, world);
        length = std::min(length, perSize * (body.size + kGrowth * away));
    }
    return length;
}

bool EdgeLengths::below(double length, const glm::dvec3& world, std::uint32_t except) const {
    return common < length || belowNearBodies(length, world, world, except);
}

bool EdgeLengths::belowNearBodies(double length, const glm::dvec3& low, const glm::dvec3& high,
                                  std::uint32_t except) const {
    return std::any_of(small.begin(), small.end(), [&](const Body& body) {
        const double reach = (length / perSize - body.size) / kGrowth;
        return body.instance != except && reach > 0.0 && distanceOf(body.box, low, high) < reach;
    });
}

}  // namespace clerestory::light
