// Helpers for reading animations of any format.
#pragma once

#include "scene/scene.h"

#include <set>
#include <string>

namespace clerestory {

// The node's rest transform.
glm::dmat4 worldFromNode(const Scene& scene, Index node);

// The position of a skinned mesh's root: that of the first joint, rounded to kilometres. Vertices
// far from the world's origin keep their precision; near the origin the root is at 0.
glm::dvec3 skinOrigin(const Scene& scene, Index firstJoint);

// Decomposes a matrix. Shear is lost.
Transform partsOf(const glm::dmat4& matrix);

// `requestedName` after cleanText(), or "clip N" if that is empty; made unique among `names` and
// added to them. number: the clip's index in the file.
std::string uniqueClipName(std::set<std::string>& names, const std::string& requestedName,
                           std::size_t number);

// Appends the node to Scene::movingNodes, which must not contain it, and returns the index. kNone
// if numbers in `rest` are too large.
Index addMovingNode(Scene& scene, Index node, const Transform& rest);

// Adds the clip unless it has no tracks; its duration is the time of the last key. dropped: the
// number of channels that were skipped, for a warning.
void addClip(Scene& scene, Clip clip, std::uint64_t dropped);

}  // namespace clerestory
