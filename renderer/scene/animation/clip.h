// Animation clips: key frames of node transforms and morph weights (glTF 2.0, section 3.11 and
// appendix C). Plain values, seconds and metres. poseAt() of scene.h evaluates them.
//
// Does not: read files, move vertices (animation/deformation.h), depend on cameras or requests.
#pragma once

#include "scene/material.h"

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace clerestory {

struct Transform {
    glm::dvec3 translation{0.0};
    glm::dquat rotation{1.0, 0.0, 0.0, 0.0};  // unit
    glm::dvec3 scale{1.0};
};
// translation * rotation * scale. A scale of 0 along an axis, with which files hide objects, is
// replaced by a millionth of the largest: the matrix is always invertible.
glm::dmat4 matrixOf(const Transform& transform);

// A node that a track of a clip moves. Without a clip its transform is Node::parentFromLocal.
struct MovingNode {
    Index node = 0;
    Transform rest;
};

// Weights of the morph targets of the meshes at one node.
struct MorphWeights {
    Index node = 0;
    std::vector<float> rest;
};

enum class Interpolation : std::uint32_t { step, linear, cubicSpline };
enum class AnimatedProperty : std::uint32_t { translation, rotation, scale, weights };

struct Track {
    AnimatedProperty property = AnimatedProperty::translation;
    Index target = 0;  // in Scene::movingNodes; for weights in Scene::morphWeights
    Interpolation interpolation = Interpolation::linear;
    std::vector<float> times;  // seconds, from 0, ascending, at least one
    // components() numbers for each time: 3, 4 (unit x y z w), or one for each weight. A cubic
    // spline has three times as many: in-tangent, value, out-tangent; tangents are per second.
    std::vector<float> values;

    std::size_t components() const;  // of one value
};

struct Clip {
    std::string name;       // not empty, unique in the scene
    double duration = 0.0;  // seconds: the last key's time
    std::vector<Track> tracks;
};

// The time within the clip: `time` up to the clip's end, then repeating. 0 for a clip of duration
// 0.
double localTime(const Clip& clip, double time);

// Writes the track's value, components() numbers, to `out`. Constant before the first key and after
// the last one. Rotations have unit length.
void sample(const Track& track, double time, std::span<double> out);

// Whether the track is valid: sample() then reads nothing out of range and returns finite numbers.
// `targets`: the number of possible targets.
bool isValid(const Track& track, std::size_t targets);

// Largest absolute value in a track: products of a few stay finite.
inline constexpr float kMaxKey = 1e9f;

}  // namespace clerestory
