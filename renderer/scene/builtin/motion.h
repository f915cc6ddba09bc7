// Clips, skins and shapes of built-in scenes, made by formula. Seconds, metres, radians.
#pragma once

#include "scene/mesh_builder.h"

#include <functional>
#include <string>
#include <vector>

namespace clerestory::motion {

// From now on the node may be moved; it stands at `rest`. Returns its place in Scene::movingNodes.
Index mayMove(Scene& scene, Index node, const Transform& rest);

// Turns about an axis through the node at an even pace, `turns` times round in `duration`, from how
// the node stands at rest; backwards when `turns` is below 0.
Track turning(const Scene& scene, Index movingNode, const glm::dvec3& axis, int turns,
              double duration);

// Through value(t) at `keys` even steps, as a cubic spline. What value() gives at 0 and at
// `duration` must be the same, and its slope too: central differences run across the seam.
Track repeating(AnimatedProperty moved, Index target, double duration, int keys,
                const std::function<std::vector<double>(double t)>& value);

std::vector<double> numbers(const glm::dvec3& v);
std::vector<double> numbers(const glm::dquat& q);

// Influences of each of the draft's vertices; their shares sum up to 1, at most four each.
using Influences = std::vector<std::vector<Influence>>;
// Draws the mesh at a node of its own.
void placeSkinned(Scene& scene, MeshDraft draft, const Influences& influences, Skin skin);

// What each target adds to each of the draft's vertices (MorphDelta::vertex is not read). Draws the
// mesh at the node and returns the place of its weights, which rest at 0.
Index placeMorphing(Scene& scene, MeshDraft draft, Index node,
                    const std::vector<std::vector<MorphDelta>>& targets);

}  // namespace clerestory::motion
