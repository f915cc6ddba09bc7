// Geometry that built-in scenes are made of. Everything is appended to a MeshDraft with unit
// normals, texture coordinates in metres (repeats per metre are the material's affair) and front
// faces counter-clockwise seen from outside. Lengths in metres, angles in radians.
#pragma once

#include "scene/mesh_builder.h"

#include <functional>
#include <span>
#include <vector>

namespace clerestory::shapes {

MeshDraft draft(std::string name, Index material);

// A parallelogram: corner, corner + u, corner + u + v, corner + v; its front is cross(u, v). Cut
// into `columns` x `rows` so that vertex colours have somewhere to live.
void addPatch(MeshDraft& mesh, const glm::vec3& corner, const glm::vec3& u, const glm::vec3& v,
              int columns = 1, int rows = 1);

void addBox(MeshDraft& mesh, const glm::vec3& min, const glm::vec3& max);

// A surface point with its normal.
struct SurfacePoint {
    glm::vec3 position, normal;
};

// A grid of columns x rows over u, v in 0..1. Texture coordinates are (u, v) * textureSize. The
// front is the side that the normals point to.
void addGrid(MeshDraft& mesh, int columns, int rows, const glm::vec2& textureSize,
             const std::function<SurfacePoint(float u, float v)>& surface);

// Turns a profile of (radius, height) about +Y through `foot`. The profile runs with the solid on
// its left: upwards on the outside. Its corners sharper than `crease` keep their edge.
void addLathe(MeshDraft& mesh, const glm::vec3& foot, std::span<const glm::vec2> profile,
              int segments, float crease = 0.6f);

// Half a turn from the lower to the upper pole.
void addSphere(MeshDraft& mesh, const glm::vec3& center, float radius, int segments);

// A round tube along a path, with flat ends unless the path closes. radius(t) for t in 0..1.
void addTube(MeshDraft& mesh, std::span<const glm::vec3> path,
             const std::function<float(float)>& radius, int sides, bool closed = false);

// Moves everything from vertex `first` on.
void transformFrom(MeshDraft& mesh, std::size_t first, const glm::mat4& m);

// Multiplies vertex colours from vertex `first` on.
void shadeFrom(MeshDraft& mesh, std::size_t first,
               const std::function<float(const Vertex&)>& shade);

// Points on a smooth curve through all of `through` (Catmull-Rom), `steps` between neighbours.
std::vector<glm::vec2> smooth(std::span<const glm::vec2> through, int steps);
std::vector<glm::vec3> smooth(std::span<const glm::vec3> through, int steps);

// addMesh and a node and an instance in one.
void place(Scene& scene, MeshDraft mesh, const glm::dmat4& worldFromMesh = glm::dmat4(1.0));

}  // namespace clerestory::shapes
