// Several scenes in one, each with a transform.
//
//     const Scene both = joined({{&table, "table", glm::dmat4(1.0)}, {&lamp, "lamp", onTheTable}});
//
// Nodes, materials, lights, cameras, clips, variants and probes are named "table/leg": the part,
// a slash, and their own names. The node of a part, above all of its nodes but those of skinned
// meshes, has the name of the part.
#pragma once

#include "scene/fields.h"
#include "scene/scene.h"
#include "scene/transform_parts.h"

#include <array>
#include <concepts>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace clerestory {

// A scene of the list in a request.
struct PlacedScene {
    std::string scene;                // id
    std::optional<std::string> name;  // none: the id
    std::optional<glm::dvec3> translation;
    std::optional<Quaternion> rotation;
    std::optional<glm::dvec3> scale;
    std::optional<std::array<double, 16>> matrix;
};

inline constexpr std::size_t kMaxPlacedScenes = 16;

template <class P, class V>
requires std::same_as<std::remove_const_t<P>, PlacedScene>
void fields(P& p, V&& visit) {
    visit("scene", p.scene, Required{Text{128}}, "id of a scene");
    visit("name", p.name, Text{128},
          "precedes the names of its nodes, materials and lights: name/node; its id when absent, "
          "with a number where ids repeat");
    visit("translation", p.translation, Range{-1e9, 1e9, "metres"},
          "position of the scene in the world");
    visit("rotation", p.rotation, Rotation{},
          "quaternion x y z w, 3x3 matrix (column-major), or radians about X, then Y, then Z");
    visit("scale", p.scale, Range{-1e6, 1e6}, "a factor along each axis, not 0");
    visit("matrix", p.matrix, Range{-1e9, 1e9},
          "the whole transform, column-major, instead of translation, rotation and scale");
}

// The field `scene` of a request: an id, or a list whose first id it then is.
struct PlacedScenes {
    std::string& id;
    std::vector<PlacedScene>& parts;
};

// Checks transforms, and that names are not empty or repeated. `pointer`: JSON Pointer of the list.
std::vector<FieldError> problems(const std::vector<PlacedScene>& parts,
                                 const std::string& pointer = "/scene");

struct ScenePart {
    const Scene* scene;
    std::string name;
    glm::dmat4 worldFromScene;
};
// `scenes` are those that the parts name, in the same order.
std::vector<ScenePart> scenePartsOf(const std::vector<PlacedScene>& placed,
                                    std::span<const Scene* const> scenes);

std::uint64_t geometryBytes(const Scene& scene);  // of vertices and indices
inline constexpr std::uint64_t kMaxJoinedBytes = 1ull << 30;

// At least one part. Lists of the result are those of the parts one after another. Its id,
// environment map and rotation are those of the first; its images have no texels. Throws
// std::length_error if it would need more than kMaxJoinedBytes.
Scene joined(const std::vector<ScenePart>& parts);

// What joined() has thrown, as the error of a request's list.
FieldError problemOf(const std::length_error& tooLarge);

// Gives the images of joined(parts) the texels of the parts' images.
void copyTexels(Scene& whole, const std::vector<ScenePart>& parts);

// That of joined(), without making it.
std::uint64_t contentHash(const std::vector<ScenePart>& parts);

// One sentence for each part.
std::vector<std::string> explained(const std::vector<PlacedScene>& parts);

}  // namespace clerestory
