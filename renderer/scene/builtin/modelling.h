// Geometry and procedural textures of built-in scenes, the same on every machine.
//
// Functions of `shapes` append to a MeshDraft with unit normals, texture coordinates in metres
// (materials scale them) and front faces that are counter-clockwise seen from outside. Lengths in
// metres, angles in radians.
#pragma once

#include "scene/mesh_builder.h"
#include "scene/scene.h"

#include <functional>
#include <span>
#include <vector>

namespace clerestory::shapes {

MeshDraft draft(std::string name, Index material);

// A parallelogram: corner, corner + u, corner + u + v, corner + v; its front is cross(u, v).
// Divided into `columns` x `rows` cells for vertex colours.
void addPatch(MeshDraft& mesh, const glm::vec3& corner, const glm::vec3& u, const glm::vec3& v,
              int columns = 1, int rows = 1);

void addBox(MeshDraft& mesh, const glm::vec3& min, const glm::vec3& max);

// A surface point with its normal.
struct GridPoint {
    glm::vec3 position, normal;
};

// A grid of columns x rows over u, v in 0..1. Texture coordinates are (u, v) * textureSize. The
// front is the side that the normals point to.
void addGrid(MeshDraft& mesh, int columns, int rows, const glm::vec2& textureSize,
             const std::function<GridPoint(float u, float v)>& surface);

// A surface of revolution: a profile of (radius, height) about +Y through `foot`. The solid is to
// the left of the profile: upwards on the outside. Corners sharper than `crease` have hard edges.
void addLathe(MeshDraft& mesh, const glm::vec3& foot, std::span<const glm::vec2> profile,
              int segments, float crease = 0.6f);

void addSphere(MeshDraft& mesh, const glm::vec3& center, float radius, int segments);

// A round tube along a path, with flat ends unless the path closes. radius(t) for t in 0..1.
void addTube(MeshDraft& mesh, std::span<const glm::vec3> path,
             const std::function<float(float)>& radius, int sides, bool closed = false);

// Transforms all vertices from `first` on.
void transformFrom(MeshDraft& mesh, std::size_t first, const glm::mat4& m);

// Multiplies the colours of all vertices from `first` on.
void shadeFrom(MeshDraft& mesh, std::size_t first,
               const std::function<float(const Vertex&)>& shade);

// Points on a smooth curve through all of `through` (Catmull-Rom), `steps` between neighbours.
std::vector<glm::vec2> smooth(std::span<const glm::vec2> through, int steps);
std::vector<glm::vec3> smooth(std::span<const glm::vec3> through, int steps);

// Adds the mesh, a node and an instance.
void addToScene(Scene& scene, MeshDraft mesh, const glm::dmat4& worldFromMesh = glm::dmat4(1.0));

}  // namespace clerestory::shapes

namespace clerestory::textures {

// Value noise of several octaves that repeats after `period` cells; x and y in 0..1; result 0..1.
float noise(float x, float y, int period, int octaves, std::uint32_t seed);

// A pseudo-random number in 0..1, a function of its arguments.
float hash(std::uint32_t x, std::uint32_t y, std::uint32_t seed);

// Evaluates `color` at texel centres (u, v in 0..1, v downwards) and builds the mip levels. `color`
// is in the encoding of the texture: sRGB codes / 255 for ColorSpace::srgb. It is called from two
// threads at once.
Index add(Scene& scene, std::string name, std::uint32_t width, std::uint32_t height,
          ColorSpace space, const std::function<glm::vec4(float u, float v)>& color);

// A texture of one value: an occlusion map that reduces a room's ambient light.
Index addConstant(Scene& scene, std::string name, float value);

}  // namespace clerestory::textures
