// The environment as the computation of light sees it: few texels, so that one ray represents each,
// and what all of them send to a surface.
#pragma once

#include "rays/cube_map.h"
#include "scene/environment.h"

#include <glm/glm.hpp>

#include <vector>

namespace clerestory::light {

// Directions have the axes of the map. Intensity 1, without the map's own sun.
class Sky {
public:
    explicit Sky(const EnvironmentMap& map);

    const rays::CubeMap& map() const { return map_; }
    // along: of any length above 0.
    glm::vec3 radiance(const glm::vec3& along) const { return rgb(map_, along); }
    // Over pi, of a surface with this unit normal that sees all of it: the mean that rays with the
    // density of cosines find.
    glm::vec3 irradiance(const glm::vec3& normal) const { return rgb(irradiance_, normal); }

    // Whether windows or lights in the map give a large part of its light, which rays with the
    // density of cosines rarely find.
    bool uneven() const { return uneven_; }
    // A unit direction with about the density of the light. u, v: in [0, 1).
    glm::vec3 sample(float u, const glm::vec2& v) const;
    // Of sample(), per steradian; above 0. along: unit.
    float density(const glm::vec3& along) const;

private:
    static glm::vec3 rgb(const rays::CubeMap& cube, const glm::vec3& along);
    void measureTexels();

    rays::CubeMap map_, irradiance_;
    std::vector<double> ends_;  // of the shares of texels in the light, ascending; the last is 1
    std::vector<float> densities_;  // at the centres of texels, times the cube of their distance
    bool uneven_ = false;
};

}  // namespace clerestory::light
