// The static triangles of a scene as rays hit them, and those of them that emit.
#pragma once

#include "light/bake_input.h"
#include "rays/path.h"
#include "rays/triangle_tree.h"
#include "scene/flat_mirrors.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <vector>

namespace clerestory::light {

inline constexpr std::uint8_t kNoMirror = 255;

// A triangle for light between surfaces. `plain`: it has no holes and is neither blended nor glass;
// see PathTracer::middleOf().
struct Face {
    glm::vec3 normal{0.0f};  // world, on the front; any length
    glm::vec3 albedo{0.0f};
    glm::vec3 through{0.0f};  // of the light of the other side, as rays::SurfaceHit
    glm::vec3 emitted{0.0f};
    float density = 0.0f;  // of rays towards emitters, per square metre
    bool plain = false;
    bool twoSided = false;
    bool ofBody = false;              // its back is the inside of a body, see closedBodies()
    std::uint8_t mirror = kNoMirror;  // of LightRays; it reflects instead of scattering
};

// A triangle that emits.
struct Emitter {
    glm::vec3 a, ab, ac;   // world axes, from the origin
    double end = 0.0;      // of its part of the sum of powers, 0..1
    float density = 0.0f;  // per square metre
    bool plain = false;    // rays that meet it at random count, too
};

// Of all triangles of the tree, in its order.
std::vector<Face> facesOf(const BakeInput& input, const rays::TriangleTree& tree,
                          const rays::PathTracer& tracer);
// Flat mirrors, relative to the origin of the tree's triangles; sets Face::mirror of theirs.
std::vector<FlatMirror> mirrorsOf(const BakeInput& input, const rays::TriangleTree& tree,
                                  std::vector<Face>& faces, const glm::dvec3& origin);
// Sets Face::density of those that emit. Empty without emission.
std::vector<Emitter> emittersOf(const BakeInput& input, const rays::TriangleTree& tree,
                                std::vector<Face>& faces);

}  // namespace clerestory::light
