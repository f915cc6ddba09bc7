// What readers of all formats share: adding clips to a scene, and the final processing of imported
// scenes, which clamps numbers to their ranges, makes texts valid UTF-8, handles singular
// transforms and enforces limits.
#pragma once

#include "scene/import/base/types.h"
#include "scene/scene.h"

#include <set>
#include <string>

namespace clerestory {

// Clamps every factor to the range in the material's field table. Adds a warning if one changed.
void cleanMaterial(Material& material, Scene& scene);

// Adds `primitives` to `total`. Throws ImportError above the limit.
void countPrimitives(std::uint64_t& total, std::uint64_t primitives, const ImportLimits& limits);

// The last step: removes singular instances, cleans texts, sets the hash. Throws ImportError if
// there is nothing to draw or the scene is invalid.
void finishScene(Scene& scene);
// Throws ImportError if the instances have more primitives than the limit.
void requireDrawable(const Scene& scene, const ImportLimits& limits);

// The node's rest transform.
glm::dmat4 worldFromNode(const Scene& scene, Index node);

// The position of a skinned mesh's root: that of the first joint, rounded to kilometres. Vertices
// far from the world's origin keep their precision; near the origin the root is at 0.
glm::dvec3 skinOrigin(const Scene& scene, Index firstJoint);

// `requestedName` after cleanText(), or "KIND N" if that is empty; made unique among `names` and
// added to them. number: its index in the file.
std::string uniqueName(std::set<std::string>& names, const std::string& requestedName,
                       const std::string& kind, std::size_t number);

// Appends the node to Scene::movingNodes, which must not contain it, and returns the index. kNone
// if numbers in `rest` are too large.
Index addMovingNode(Scene& scene, Index node, const Transform& rest);

// Adds the clip unless it has no tracks; its duration is the time of the last key. dropped: the
// number of channels that were skipped, for a warning.
void addClip(Scene& scene, Clip clip, std::uint64_t dropped);

}  // namespace clerestory
