// Punctual lights, a square that hides them from a wall, and pictures with and without its shadow.
#pragma once

#include "support.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace clerestory::test {

inline glm::dmat4 shiningAlong(const glm::dvec3& position, const glm::dvec3& along) {
    glm::dmat4 m(1.0);  // lights shine along their -Z
    const glm::dvec3 z = -glm::normalize(along);
    const glm::dvec3 x = glm::normalize(glm::cross(glm::dvec3(0.3, 0.9, 0.1), z));
    m[0] = glm::dvec4(x, 0.0);
    m[1] = glm::dvec4(glm::cross(z, x), 0.0);
    m[2] = glm::dvec4(z, 0.0);
    m[3] = glm::dvec4(position, 1.0);
    return m;
}

inline Light pointLight() {
    return {.intensity = glm::vec3(4.0f)};
}
inline Light spotLight() {
    return {.kind = LightKind::spot,
            .intensity = glm::vec3(4.0f),
            .innerConeAngle = 1.0f,
            .outerConeAngle = 1.1f};
}
inline Light sunLight() {
    return {.kind = LightKind::directional, .intensity = glm::vec3(2.0f)};
}

struct Pictures {
    Image with, without;
};
inline Pictures draw(FrameRequest r) {
    Pictures pictures;
    pictures.without = renderer().render(r).image;
    r.effects.shadows = true;
    pictures.with = renderer().render(r).image;
    return pictures;
}

// A square of edge 1 at z = 1 over a wall at z = 0, seen from far below it, through its back: the
// camera sees the wall only. `size`: factor on all lengths.
inline FrameRequest squareOverWall(const Light& light, const glm::dvec3& lightAt, Material blocker,
                                   double size = 1.0, const glm::dvec3& origin = glm::dvec3(0.0)) {
    Scene scene;
    const auto s = static_cast<float>(size);
    const Index wall = addMaterial(scene, lambert(0.5f));
    place(scene, quad(2.0f * s, wall), glm::translate(glm::dmat4(1.0), origin));
    place(scene, quad(0.5f * s, addMaterial(scene, std::move(blocker))),
          glm::translate(glm::dmat4(1.0), origin + glm::dvec3(0.0, 0.0, size)));
    Light scaled = light;
    if (scaled.kind != LightKind::directional) scaled.intensity *= s * s;
    addLight(scene, scaled, shiningAlong(origin + size * lightAt, {0.0, 0.0, -1.0}));
    FrameRequest r =
        request(std::move(scene), "square over wall", origin + size * glm::dvec3(0.0, 0.0, 0.9));
    r.width = r.height = 201;
    return r;
}

// Pixels of the wall by their distance from the middle, the greater of both coordinates, in edges
// of the square. The camera at z = 0.9 sees 0.9 to each side.
inline double fromMiddle(std::uint32_t x, std::uint32_t y) {
    const auto at = [](std::uint32_t i) { return std::abs((i + 0.5) / 201.0 * 2.0 - 1.0) * 0.9; };
    return std::max(at(x), at(y));
}

// half: of the shadow's edge, metres; blur: of its rim.
inline void expectShadow(const Pictures& p, double half, double blur, const std::string& name) {
    std::size_t dark = 0, bright = 0, wrong = 0;
    for (std::uint32_t y = 0; y < 201; ++y) {
        for (std::uint32_t x = 0; x < 201; ++x) {
            const double distance = fromMiddle(x, y);
            const float with = color(p.with, x, y).x, without = color(p.without, x, y).x;
            if (distance < half - blur) {
                ++dark;
                wrong += with > 0.0f;
            } else if (distance > half + blur) {
                ++bright;
                wrong += std::abs(with - without) > 1e-3f * without;
            }
        }
    }
    EXPECT_EQ(wrong, 0u) << name;
    EXPECT_GT(dark, 1000u) << name;
    EXPECT_GT(bright, 1000u) << name;
}

}  // namespace clerestory::test
