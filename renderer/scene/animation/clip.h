// What moves by itself: clips of key frames on nodes and on morph weights (glTF 2.0, section 3.11
// and appendix C). Plain values, seconds and metres; a moment of them is poseAt() of scene.h.
//
// Does not: read files, move vertices (animation/deformation.h), know cameras or requests.
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
// translation * rotation * scale. A scale of 0 along an axis, by which files make things vanish, is
// a millionth of the longest: the transform always has an inverse.
glm::dmat4 matrixOf(const Transform& transform);

// A node that some track of some clip moves. What a clip leaves alone is as at rest, which is
// Node::parentFromLocal.
struct MovingNode {
    Index node = 0;
    Transform rest;
};

// Shares of the morph targets of the meshes at one node.
struct MorphWeights {
    Index node = 0;
    std::vector<float> rest;
};

// What happens between two keys.
enum class Interpolation : std::uint32_t { step, linear, cubicSpline };
enum class AnimatedProperty : std::uint32_t { translation, rotation, scale, weights };

struct Track {
    AnimatedProperty moved = AnimatedProperty::translation;
    Index target = 0;  // into Scene::movingNodes; of weights, into Scene::morphWeights
    Interpolation between = Interpolation::linear;
    std::vector<float> times;  // seconds, from 0, ascending, at least one
    // For each time its numbers: 3, 4 (unit x y z w) or as many as there are weights. Of a cubic
    // spline three times as many: the tangent that comes in, the value, the tangent that goes out;
    // tangents are per second.
    std::vector<float> values;

    std::size_t components() const;  // of one value
};

struct Clip {
    std::string name;       // not empty; no two of a scene alike
    double duration = 0.0;  // seconds: the last key's time
    std::vector<Track> tracks;
};

// A moment of the clip: itself up to the clip's end, from then on round and round. 0 for a clip
// without duration.
double localTime(const Clip& clip, double time);

// The track's value, `out` of components() numbers. Before its first key and after its last one
// it stands still. Rotations come out of unit length.
void sample(const Track& track, double time, std::span<double> out);

// Whether the track holds what its words promise, so that sample() reads nothing out of range and
// returns finite numbers. `targets`: how many there are to move.
bool sound(const Track& track, std::size_t targets);

// Greatest magnitude of any number of a track: products of a few stay finite.
inline constexpr float kMaxKey = 1e9f;

}  // namespace clerestory
