// What the readers of animations share, whatever the format.
#pragma once

#include "scene/scene.h"

#include <set>
#include <string>

namespace clerestory {

// Where a node is at rest.
glm::dmat4 worldFromNode(const Scene& scene, Index node);

// Where the root stands that a skinned mesh hangs on: near its first joint, in whole kilometres. So
// vertices keep their precision far from the origin, and nothing changes near it.
glm::dvec3 skinOrigin(const Scene& scene, Index firstJoint);

// A matrix taken apart; what it shears is lost.
Transform partsOf(const glm::dmat4& matrix);

// `wanted` without what terminals and pages stumble over, or "clip N" where nothing is left, and
// told apart from `names`, to which it is added. number: of the clip in its file, from 0.
std::string uniqueClipName(std::set<std::string>& names, const std::string& wanted,
                           std::size_t number);

// The node among Scene::movingNodes; it must not be there yet. kNone where `rest` holds numbers too
// large to move.
Index addMovingNode(Scene& scene, Index node, const Transform& rest);

// Adds the clip, as long as its last key, unless it has no tracks. dropped: channels that were left
// out of it; they are a warning.
void addClip(Scene& scene, Clip clip, std::uint64_t dropped);

}  // namespace clerestory
