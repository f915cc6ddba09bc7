// Composition of what a request shows: nodes of a scene that are hidden, moved or given another
// material, and a ground. A pure function from a scene to another one; the loaded scene stays as it
// is.
//
//     if (const auto errors = problems(scene, nodes); errors.empty()) draw(composed(scene,
//     {nodes}));
//
// Does not: join scenes (scene/join.h), read files, change vertices, know requests or OpenGL.
#pragma once

#include "scene/fields.h"
#include "scene/geometry.h"
#include "scene/ground.h"
#include "scene/scene.h"
#include "scene/transform_parts.h"

#include <array>
#include <concepts>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

namespace clerestory {

enum class Space { parent, world };

// Selects all nodes of the name `node`, or whose names fit the pattern (scene/name_pattern.h).
// Hiding and materials include everything below them; lights below a hidden node are off. A new
// transform replaces the node's own, in parts: what is absent of translation, rotation and scale
// stays, animated or not, and animation of the others ends.
struct NodeOverride {
    std::string node;
    std::optional<bool> hidden;
    std::optional<std::string> material;  // of the scene
    std::optional<glm::dvec3> translation;
    std::optional<Quaternion> rotation;
    std::optional<glm::dvec3> scale;
    std::optional<std::array<double, 16>> matrix;  // column-major; instead of the three above
    // world: relative to the world, where the node then stays whatever is above it.
    Space relativeTo = Space::parent;

    bool moves() const { return partsOf(*this).any(); }
    bool operator==(const NodeOverride&) const = default;
};

inline constexpr std::size_t kMaxNodeOverrides = 64;

template <class O, class V>
requires std::same_as<std::remove_const_t<O>, NodeOverride>
void fields(O& o, V&& visit) {
    visit("node", o.node, Required{Text{256}},
          "name of the nodes to change; `*` matches any characters");
    visit("hidden", o.hidden, Flag{},
          "true: the node and everything below it are left out; lights below it are off");
    visit("material", o.material, Text{256},
          "name of a material of the scene, for everything at and below the node");
    visit("translation", o.translation, Range{-1e9, 1e9, "metres"},
          "replaces that of the node; absent parts of translation, rotation and scale are kept");
    visit("rotation", o.rotation, Rotation{},
          "replaces that of the node: quaternion x y z w, 3x3 matrix (column-major), or radians "
          "about X, then Y, then Z");
    visit("scale", o.scale, Range{-1e6, 1e6},
          "replaces that of the node: a factor along each of its axes, not 0");
    visit("matrix", o.matrix, Range{-1e9, 1e9},
          "the whole transform, column-major, instead of translation, rotation and scale");
    visit("relativeTo", o.relativeTo,
          Choice<Space>{{{"parent", Space::parent}, {"world", Space::world}}},
          "space of the transform; world: the node stays there even if its parents move");
}

// Checks that names exist in the scene and that transforms are invertible and of moderate size.
// `pointer` is the JSON Pointer of the list.
std::vector<FieldError> problems(const Scene& scene, const std::vector<NodeOverride>& nodes,
                                 const std::string& pointer = "/nodes");

// The part of a request that composes a scene.
struct Composition {
    std::vector<NodeOverride> nodes;     // in order; a later one wins
    std::optional<std::string> variant;  // of the materials; nodes with a material keep that
    std::optional<GroundPlane> ground = std::nullopt;
    bool shadowCatcher = false;  // the ground is one

    bool empty() const { return nodes.empty() && !ground; }
};

// A scene with the same vertices, meshes, materials and images, after which those of the ground
// come. Its instances are those that are not hidden, so that their numbers may differ. The hash of
// its content is that of the scene and of the composition; images without texels are no problem.
// The names must exist in the scene.
Scene composed(const Scene& scene, const Composition& composition);

// That of composed(), without making it.
std::uint64_t contentHash(const Scene& scene, const Composition& composition);

// One sentence for each change, such as "node lid: moved, relative to its parent".
std::vector<std::string> explained(const Scene& scene, const Composition& composition);

}  // namespace clerestory
