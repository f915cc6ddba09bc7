// Procedural clips, skins and morph targets of built-in scenes. Seconds, metres, radians.
#pragma once

#include "scene/mesh_builder.h"

#include <functional>
#include <string>
#include <vector>

namespace clerestory::motion {

// Adds the node to Scene::movingNodes, with its rest transform. Returns the index there.
Index addMovingNode(Scene& scene, Index node, const Transform& rest);

// Rotates the node about an axis through it, `turns` times in `duration`, starting at the rest
// pose; backwards if `turns` is negative.
Track turning(const Scene& scene, Index movingNode, const glm::dvec3& axis, int turns,
              double duration);

// A cubic spline through value(t) at `keys` equal steps. value() and its derivative must be equal
// at 0 and at `duration`, because tangents are central differences of the periodic function.
Track repeating(AnimatedProperty property, Index target, double duration, int keys,
                const std::function<std::vector<double>(double t)>& value);

std::vector<double> numbers(const glm::dvec3& v);
std::vector<double> numbers(const glm::dquat& q);

// For each vertex of the draft at most four influences, whose shares add up to 1.
using Influences = std::vector<std::vector<Influence>>;
// Adds an instance at a new node.
void placeSkinned(Scene& scene, MeshDraft draft, const Influences& influences, Skin skin);

// targets: for each target and each vertex of the draft the offsets (MorphDelta::vertex is not
// used). Adds an instance at the node. Returns the index in Scene::morphWeights; the rest weights
// are 0.
Index placeMorphing(Scene& scene, MeshDraft draft, Index node,
                    const std::vector<std::vector<MorphDelta>>& targets);

}  // namespace clerestory::motion
