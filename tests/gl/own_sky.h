// Environment maps whose radiance is a function of direction.
#pragma once

#include "support.h"

namespace clerestory::test {

inline glm::dvec3 texelDirection(std::uint32_t face, double s,
                                 double t) {  // OpenGL 4.3, table 8.18
    switch (face) {
        case 0:
            return {1, -t, -s};
        case 1:
            return {-1, -t, s};
        case 2:
            return {s, 1, t};
        case 3:
            return {s, -1, -t};
        case 4:
            return {s, -t, 1};
        default:
            return {-s, -t, -1};
    }
}

// A map of `light`, looked at in directions turned by mapFromWorld.
template <class Light>
void addMap(const std::string& name, std::uint32_t size, const glm::dmat3& mapFromTexel,
            Light&& light) {
    auto map = std::make_shared<EnvironmentMap>();
    map->name = name;
    map->faceSize = size;
    for (std::uint32_t face = 0; face < 6; ++face) {
        for (std::uint32_t y = 0; y < size; ++y) {
            for (std::uint32_t x = 0; x < size; ++x) {
                const glm::dvec3 d = texelDirection(face, (x + 0.5) / size * 2.0 - 1.0,
                                                    (y + 0.5) / size * 2.0 - 1.0);
                map->texels.push_back(light(mapFromTexel * glm::normalize(d)));
            }
        }
    }
    completeMap(*map);
    renderer().addEnvironment(map);
}

}  // namespace clerestory::test
