// Flat mirrors as sources of light: each light has an image behind them, which lights surfaces as
// the light does, through the mirror.
//
//     for (const FlatMirror& mirror : flatMirrors(scene, pose, materials, surfaces))
//         if (mirror.shows(light, point)) light += irradianceAt(mirror.imageOf(light), point);
//
// Pure. Whether the mirror covers the way to the image, and whether anything hides the light, is
// for the caller to find out.
#pragma once

#include "scene/classification.h"
#include "scene/geometry.h"
#include "scene/scene.h"

#include <glm/glm.hpp>

#include <cstddef>
#include <vector>

namespace clerestory {

struct FlatMirror {
    std::size_t surface = 0;  // in the list of surfaces that was given
    Plane plane;              // world
    Bounds box;               // world
    bool twoSided = false;

    glm::dvec3 mirrored(const glm::dvec3& point) const {
        return point - 2.0 * plane.distance(point) * plane.normal;
    }
    template <class Direction>
    Direction turned(const Direction& d) const {
        const Direction n(plane.normal);
        return d - n * (2 * glm::dot(n, d));
    }

    // The image of a light that has a kind, a position and a direction toLight, world.
    template <class AnyLight>
    AnyLight imageOf(AnyLight light) const {
        light.position = mirrored(light.position);
        light.toLight = turned(light.toLight);
        return light;
    }
    // Whether the light and the point are on the same side, where the mirror reflects, and the way
    // from the point to the image passes through the mirror's box.
    template <class AnyLight>
    bool shows(const AnyLight& light, const glm::dvec3& point) const {
        const bool placed = light.kind != LightKind::directional;
        const double height = plane.distance(point);
        const double above = placed ? plane.distance(light.position)
                                    : glm::dot(plane.normal, glm::dvec3(light.toLight));
        if (!(height * above > 0.0) || (height < 0.0 && !twoSided)) return false;
        const glm::dvec3 way =
            placed ? mirrored(light.position) - point : turned(glm::dvec3(light.toLight));
        const double part = placed ? height / (height + above) : height / above;
        return nearBox(point + part * way);
    }
    // With coordinates relative to an origin.
    FlatMirror relativeTo(const glm::dvec3& origin) const;

private:
    bool nearBox(const glm::dvec3& point) const;
};

inline constexpr std::size_t kMaxFlatMirrors = 16;

// Metals in one plane without bumps or layers, of roughness 0.1 at most, so that an image has
// the light of the lobe. Largest first, at most kMaxFlatMirrors. surfaces: surfacesOf() the scene.
std::vector<FlatMirror> flatMirrors(const Scene& scene, const Pose& pose,
                                    const MaterialBindings& materials,
                                    const std::vector<Surface>& surfaces);

}  // namespace clerestory
