// An environment map as a light: radiance, irradiance, and importance sampling of directions.
#pragma once

#include "reference/vectors.h"
#include "scene/environment.h"

#include <vector>

namespace clerestory::reference {

class EnvironmentLight {
public:
    // map must outlive this object. intensity: factor on its radiance.
    EnvironmentLight(const EnvironmentMap& map, const glm::dmat3& worldFromMap, double intensity);

    // Radiance from a direction (world, unit) without the map's sun; bilinear, also across the
    // edges of faces.
    glm::dvec3 radiance(const glm::dvec3& direction) const;

    // Unoccluded irradiance / pi for a unit normal. Exact except for bilinear interpolation: within
    // 5e-4 of the map's maximum. Requires prepareIrradiance().
    glm::dvec3 irradianceOverPi(const glm::dvec3& normal) const;

    // A direction sampled in proportion to luminance, and its density per steradian; density 0 if
    // the map is black. Both require prepareSampling().
    struct Sample {
        glm::dvec3 direction{0.0, 1.0, 0.0};
        double pdf = 0.0;
    };
    Sample sample(const glm::dvec2& u) const;
    double pdf(const glm::dvec3& direction) const;

    void prepareIrradiance();
    void prepareSampling();

private:
    const EnvironmentMap& map_;
    glm::dmat3 worldFromMap_, mapFromWorld_;
    double intensity_;
    std::vector<glm::dvec3> irradiance_;  // six faces of (kIrradianceCells + 1)^2 grid points
    std::uint32_t cells_ = 0;             // sampling cells along a face's edge
    std::vector<double> cdf_;  // probability of all cells before one; the last entry is 1
};

}  // namespace clerestory::reference
