// A small room, and requests with light between surfaces.
#pragma once

#include "support.h"

namespace clerestory::test {

// Six squares of edge 2 about the origin that face inwards.
inline void placeRoom(Scene& scene, Index material) {
    const glm::dvec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int axis = 0; axis < 3; ++axis) {
        for (const double side : {-1.0, 1.0}) {
            const glm::dvec3 n = -side * axes[axis], x = axes[(axis + 1) % 3];
            const glm::dvec3 y = glm::cross(n, x);
            glm::dmat4 m(1.0);
            m[0] = glm::dvec4(x, 0.0);
            m[1] = glm::dvec4(y, 0.0);
            m[2] = glm::dvec4(n, 0.0);
            m[3] = glm::dvec4(-n, 1.0);
            place(scene, quad(1.0f, material), m);
        }
    }
}

// The request with the light of surfaces, complete.
inline FrameRequest lit(FrameRequest r) {
    r.effects.indirectLight = true;
    const LightState light = renderer().completeLight(r);
    EXPECT_TRUE(light.complete) << light.failure;
    EXPECT_EQ(light.share, 1.0);
    return r;
}

}  // namespace clerestory::test
