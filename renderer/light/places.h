// Where the light of a scene is gathered: at some of its vertices, so that no two places of one
// surface are much nearer to each other than a common distance. The light of each vertex is a mean
// of the places around it.
#pragma once

#include "scene/scene.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace clerestory::light {

// A point on a surface at which light is computed.
struct Receiver {
    glm::vec3 position{0.0f};  // world axes, from an origin
    // Where rays begin: next to the position, within the triangles around it. The position itself
    // may lie in the plane of another surface, whose two sides differ.
    glm::vec3 start{0.0f};
    glm::vec3 normal{0.0f};  // unit, axes of the environment map
    bool twoSided = false;
};

struct Places {
    // Different positions of vertices, normals and kinds of surfaces.
    std::vector<Receiver> points;
    // The point of vertex v of an instance is pointOf[firstOfInstance[instance] + v]; kNoLight for
    // instances that move, deform or are unlit.
    std::vector<std::int32_t> firstOfInstance;
    std::vector<std::uint32_t> pointOf;
    std::vector<std::uint32_t> chosen;  // points where light is gathered, ascending
    // The parts of point p are parts[firstPart[p]] ... parts[firstPart[p + 1] - 1]; weights above
    // 0.
    struct Part {
        std::uint32_t place;  // index of `chosen`
        float weight;
    };
    std::vector<std::uint32_t> firstPart;
    std::vector<Part> parts;
    float distance = 0.0f;  // between places, metres
    // Of points, relative to that where places are not denser: the weight in means over surfaces.
    std::vector<float> areas;

    std::span<const Part> partsOf(std::uint32_t point) const {
        return std::span(parts).subspan(firstPart[point], firstPart[point + 1] - firstPart[point]);
    }
};

struct PlacesInput {
    const Scene& scene;
    const Pose& pose;
    const MaterialBindings& materials;
    const glm::dmat3& mapFromWorld;
    glm::dvec3 origin{0.0};  // world
    double distance = 0.0;   // metres; larger if there would be more places than `limit`
    // Where set: a distance that is smaller near some points of the world.
    std::function<double(const glm::dvec3&)> distanceAt;
    std::uint32_t limit = ~0u;
    // The distance from a point along its normal to the next surface, metres; infinite if there is
    // none. Points do not share one-sided places that another surface covers: the floor under a
    // slab is dark, its top is not.
    std::function<float(const Receiver&)> clearanceAbove;
};
Places placesOf(const PlacesInput& input);

}  // namespace clerestory::light
