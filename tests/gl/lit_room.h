// A small room, places of quads, and requests with light between surfaces.
#pragma once

#include "support.h"

#include <numbers>

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

// Of a quad.
inline glm::dmat4 facingUp() {
    return glm::rotate(glm::dmat4(1.0), -0.5 * std::numbers::pi, glm::dvec3(1.0, 0.0, 0.0));
}
inline glm::dmat4 facingDown(double height) {
    return glm::translate(glm::dmat4(1.0), glm::dvec3(0.0, height, 0.0)) *
           glm::rotate(glm::dmat4(1.0), 0.5 * std::numbers::pi, glm::dvec3(1.0, 0.0, 0.0));
}

inline FrameRequest lookingAt(FrameRequest r, const glm::dvec3& from, const glm::dvec3& at) {
    r.camera.position = from;
    r.camera.target = at;
    r.width = r.height = 65;  // a pixel's centre looks straight ahead
    return r;
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
