// The environment as the computation of light sees it: few texels, so that one ray represents each,
// and what all of them send to a surface.
#pragma once

#include "rays/cube_map.h"
#include "scene/environment.h"

#include <glm/glm.hpp>

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

private:
    static glm::vec3 rgb(const rays::CubeMap& cube, const glm::vec3& along);

    rays::CubeMap map_, irradiance_;
};

}  // namespace clerestory::light
