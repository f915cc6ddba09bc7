// An environment map as light: along a direction, on a surface, and where its light comes from.
#pragma once

#include "reference/vectors.h"
#include "scene/environment.h"

#include <vector>

namespace clerestory::reference {

class EnvironmentLight {
public:
    // map must outlive it. intensity: a factor on all its light.
    EnvironmentLight(const EnvironmentMap& map, const glm::dmat3& worldFromMap, double intensity);

    // Radiance from a direction (world, unit), without the map's sun: bilinear between texels, over
    // the edges of faces too.
    glm::dvec3 along(const glm::dvec3& direction) const;

    // Irradiance / pi about a unit normal, nothing being in the way. Exact but for bilinear
    // interpolation: 5e-4 of the map's greatest share of it.
    glm::dvec3 diffuse(const glm::dvec3& normal) const;

    // A direction chosen about as often as light comes from it, and its density per steradian; 0
    // where the map is black.
    struct Choice {
        glm::dvec3 direction{0.0, 1.0, 0.0};
        double density = 0.0;
    };
    Choice choose(const glm::dvec2& random) const;
    double density(const glm::dvec3& direction) const;

    // What diffuse() and choose() look up; until called, they must not be.
    void prepareDiffuse();
    void prepareChoices();

private:
    const EnvironmentMap& map_;
    glm::dmat3 worldFromMap_, mapFromWorld_;
    double intensity_;
    std::vector<glm::dvec3> diffuse_;  // six faces of (kDiffuseCells + 1)^2, corners included
    std::uint32_t cells_ = 0;          // of the choices, along a face's edge
    std::vector<double> upTo_;         // light of all cells before one; its last is 1
};

}  // namespace clerestory::reference
