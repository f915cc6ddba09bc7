// A room whose walls have known radiance at every point, to compare reflections with.
#pragma once

#include "support.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace clerestory::test {

inline constexpr double kRoom = 3.0;  // half of its edge, metres; around the origin

// Four glowing squares on each wall, all 24 of different colours; or all of one radiance.
struct Room {
    std::optional<glm::vec3> everywhere;

    // The colour of a point on a wall; `margin`: its distance from the nearest edge between two
    // squares.
    glm::vec3 radianceAt(const glm::dvec3& p, double& margin) const {
        int axis = 0;
        for (int i = 1; i < 3; ++i) {
            if (std::abs(p[i]) > std::abs(p[axis])) axis = i;
        }
        const double u = p[(axis + 1) % 3], v = p[(axis + 2) % 3];
        margin = std::min({std::abs(u), std::abs(v), kRoom - std::abs(u), kRoom - std::abs(v)});
        return radianceOf(axis, p[axis] > 0.0, u > 0.0, v > 0.0);
    }
    glm::vec3 radianceOf(int axis, bool side, bool u, bool v) const {
        if (everywhere) return *everywhere;
        const int wall = 2 * axis + side;
        return {0.1f + 0.15f * float(wall), u ? 0.9f : 0.3f, v ? 0.7f : 0.2f};
    }
    void build(Scene& scene) const {
        for (int axis = 0; axis < 3; ++axis) {
            for (int i = 0; i < 8; ++i) {
                const bool side = i & 1, u = i & 2, v = i & 4;
                glm::dmat4 m(0.0);  // quad's X, Y and Z along u, v and the wall's axis
                m[0][(axis + 1) % 3] = m[1][(axis + 2) % 3] = m[2][axis] = 1.0;
                m[3] = glm::dvec4(0, 0, 0, 1);
                m[3][axis] = side ? kRoom : -kRoom;
                m[3][(axis + 1) % 3] = u ? 0.5 * kRoom : -0.5 * kRoom;
                m[3][(axis + 2) % 3] = v ? 0.5 * kRoom : -0.5 * kRoom;
                place(scene,
                      quad(0.5f * float(kRoom),
                           addMaterial(scene, glowing(radianceOf(axis, side, u, v)))),
                      m);
            }
        }
    }
};

}  // namespace clerestory::test
