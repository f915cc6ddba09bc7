// A ground plane below a scene, as a request adds it.
//
//     addGround(scene, {.roughness = 0.1}, false);  // a glossy floor at the scene's lowest point
//
// As a shadow catcher the plane is no surface of its own: it shows how much darker the scene makes
// a ground of any colour, and what such a ground would reflect of the scene. Plans draw it in the
// requested view only. See Scene::ground.
//
// Does not: move with what animates, follow a terrain.
#pragma once

#include "scene/fields.h"
#include "scene/scene.h"

#include <concepts>
#include <optional>
#include <string>
#include <type_traits>

namespace clerestory {

struct GroundPlane {
    std::optional<double> height;  // metres; none: just below the lowest point of the scene
    glm::dvec3 color{0.5};         // linear albedo; of a shadow catcher only what it reflects
    double metallic = 0.0;
    double roughness = 1.0;
    double reflectance = 0.04;          // at normal incidence, of what is not metal
    std::optional<double> size;         // edge of the square, metres; none: by the scene's size
    std::optional<bool> shadowCatcher;  // none: if the background is transparent
};

template <class G, class V>
requires std::same_as<std::remove_const_t<G>, GroundPlane>
void fields(G& g, V&& visit) {
    visit("height", g.height, Range{-1e9, 1e9, "metres"},
          "height of the plane in the world; just below the lowest point of the scene at time 0 "
          "when absent");
    visit("color", g.color, Range{0, 1}, "linear colour of the plane");
    visit("metallic", g.metallic, Range{0, 1}, "1: a metal, which reflects in its colour");
    visit("roughness", g.roughness, Range{0, 1},
          "roughness of the plane; up to 0.3 (metal: 0.5) it reflects the scene");
    visit("reflectance", g.reflectance, Range{0, 0.9},
          "fraction of light that the plane reflects at normal incidence, unless it is metal");
    visit("size", g.size, Range{1e-6, 1e9, "metres"},
          "edge of the square; twelve times the diagonal of the scene when absent");
    visit("shadowCatcher", g.shadowCatcher, Flag{},
          "true: the picture shows only shadows and reflections on the ground; when absent: true "
          "with a transparent background");
}

// Adds the plane as the last instance, node, mesh and material, all named `ground`. Its triangles
// are small where the scene stands, so that light at vertices shows contact. Does nothing to an
// empty scene without a height.
void addGround(Scene& scene, const GroundPlane& ground, bool shadowCatcher);

// One sentence for a plan.
std::string explained(const GroundPlane& ground, bool shadowCatcher);

}  // namespace clerestory
