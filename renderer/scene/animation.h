// Animation: clips, which are key frames of node transforms and morph weights (glTF 2.0,
// section 3.11 and appendix C) and of factors of materials, lights and cameras, and deforming
// meshes: morph targets first, then a skin (sections 3.7.2.2 and 3.7.3). Plain values, seconds and
// metres. poseAt() of scene.h evaluates clips; deformations are evaluated on the CPU once for each
// pose, so that views, rays and the reference use the same vertices.
//
// Does not: read files, depend on cameras or requests, upload to the GPU.
#pragma once

#include "scene/geometry.h"
#include "scene/material.h"

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include <concepts>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace clerestory {

struct Scene;

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

// A light whose factors clips may change. `rest`: without a clip; color times intensity is that of
// the light. See Light for their units.
struct LightFactors {
    glm::vec3 color{1.0f};
    float intensity = 1.0f;
    float range = 0.0f;
    float innerConeAngle = 0.0f;
    float outerConeAngle = 0.785398163f;
};
struct AnimatedLight {
    Index light = 0;
    LightFactors rest;
};

inline constexpr float kMaxLightIntensity = 1e9f;  // products stay finite in float

template <class L, class V>
requires std::same_as<std::remove_const_t<L>, LightFactors>
void fields(L& l, V&& visit) {
    constexpr FactorRange kStrength{0, kMaxLightIntensity, 1};
    visit("color", l.color, kStrength);
    visit("intensity", l.intensity, kStrength);
    visit("range", l.range, FactorRange{0, kMaxLightIntensity, 0});
    visit("innerConeAngle", l.innerConeAngle, FactorRange{0, 1.5707963f, 0});
    visit("outerConeAngle", l.outerConeAngle, FactorRange{1e-3f, 1.5707963f, 0.785398163f});
}

enum class Interpolation : std::uint32_t { step, linear, cubicSpline };
// visible: whether a node and all below it are drawn; from 0.5 on they are. The last three are
// factors of a material, a light or a camera, named by Track::field.
enum class AnimatedProperty : std::uint32_t {
    translation,
    rotation,
    scale,
    weights,
    visible,
    material,
    light,
    camera
};

struct Track {
    AnimatedProperty property = AnimatedProperty::translation;
    // In Scene::movingNodes, morphWeights, nodes (visible), materials, animatedLights or cameras.
    Index target = 0;
    Interpolation interpolation = Interpolation::linear;
    std::vector<float> times;  // seconds, from 0, ascending, at least one
    // components() numbers for each time: 3, 4 (unit x y z w), one for each weight, or as many as
    // the factor has. A cubic spline has three times as many: in-tangent, value, out-tangent;
    // tangents are per second.
    std::vector<float> values;
    std::string field;  // see scene/animated_field.h; empty for properties of nodes

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
// How many numbers a value of a node's property has, or a factor of the field's name; 0 for
// weights, and for a name that is no factor.
std::size_t componentsOf(AnimatedProperty property, std::string_view field);

// Largest absolute value in a track: products of a few stay finite.
inline constexpr float kMaxKey = 1e9f;

// The attributes of a vertex that a deformation changes.
struct BaseVertex {
    glm::vec3 position{0.0f};
    glm::vec3 normal{0.0f, 0.0f, 1.0f};
    glm::vec4 tangent{1.0f, 0.0f, 0.0f, 1.0f};
};

struct Skin {
    std::vector<Index> joints;              // nodes
    std::vector<glm::dmat4> jointFromMesh;  // one for each: the inverse bind matrices
};

// The weight of a joint for a vertex.
struct Influence {
    std::uint32_t joint = 0;  // in Skin::joints
    float share = 0.0f;       // the shares of a vertex add up to 1
};

// The offsets of a morph target, at weight 1, for a vertex.
struct MorphDelta {
    std::uint32_t vertex = 0;  // from 0 within the mesh
    glm::vec3 position{0.0f}, normal{0.0f}, tangent{0.0f};
};

// Each skin and each set of weights has a separate mesh. The node of a skinned mesh is a root at
// the world's origin, or translated to near the joints; vertices are relative to it.
struct Deformation {
    Index mesh = 0;
    std::uint32_t firstVertex = 0;  // in Scene::vertices, which has the rest pose
    std::vector<BaseVertex> base;   // as in the file, mesh space
    Index skin = kNone;             // in Scene::skins
    Index weights = kNone;          // in Scene::morphWeights
    std::uint32_t perVertex = 0;    // influences of each vertex; 0 without a skin
    std::vector<Influence> influences;
    std::vector<std::uint32_t>
        firstDelta;  // of each target in `deltas`, then the end; may be empty
    std::vector<MorphDelta> deltas;
    bool flatNormals = false;  // the file has no normals: one per triangle
};

// A deforming mesh in one pose.
struct DeformedMesh {
    std::uint32_t firstVertex = 0;
    std::vector<Vertex> vertices;
    Bounds bounds;                 // mesh space
    std::vector<Bounds> clusters;  // one for each cluster of the mesh
    std::uint64_t hash = 0;        // of the vertices
};

// Writes the deformed vertices to `out`: positions and directions from deformation.base, all other
// attributes from `rest`, which has the same size. The results are finite.
// weights: one for each target. worldFromJointBind: for each joint of the skin, its node's
// transform times its jointFromMesh.
void deform(const Deformation& deformation, std::span<const double> weights,
            std::span<const glm::dmat4> worldFromJointBind, std::span<const Vertex> rest,
            std::vector<Vertex>& out);

// Sets the normals of each triangle's three vertices, which no other triangle shares. `first` is
// subtracted from each index into `vertices`.
void flattenNormals(std::span<const std::uint32_t> indices, std::uint32_t first,
                    std::span<Vertex> vertices);

// The part of sceneProblems() for animations and deformations. The scene's meshes, nodes and
// indices must be valid. Empty if all animations are valid.
std::vector<std::string> motionProblems(const Scene& scene);

}  // namespace clerestory
