// The posed scene as rays meet it: its triangles in the world, in an Embree hierarchy, and what its
// materials say at a point.
#pragma once

#include "plan/request/frame_request.h"
#include "reference/vectors.h"
#include "scene/classification.h"

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

namespace clerestory::reference {

inline constexpr std::uint32_t kNoTriangle = 0xffffffffu;

struct Ray {
    glm::dvec3 origin{0.0};     // relative to World::origin(), in the world's axes, as all places
    glm::dvec3 direction{0.0};  // unit
    double nearest = 0.0, farthest = std::numeric_limits<double>::infinity();
    std::uint32_t leaves = kNoTriangle;  // the triangle it starts on, which it does not meet again
};

struct Hit {
    double distance = 0.0;
    double weightB = 0.0, weightC = 0.0;  // of the triangle's second and third corner
    std::uint32_t triangle = 0;
};

// A point of a surface, seen along a ray.
struct Point {
    glm::dvec3 place{0.0};
    glm::dvec3 face{0.0};    // unit normal of the triangle, against the ray
    glm::dvec3 normal{0.0};  // the same, interpolated, with the normal map; not below the horizon
    bool front = true;       // the ray comes from the side that counts as outside
    double reach = 0.0;      // greatest coordinate of the triangle's corners
    std::uint32_t triangle = 0;
    Index instance = 0;
    const Surface* surface = nullptr;
    const Material* material = nullptr;
    glm::dvec3 baseColor{1.0};
    double coverage = 1.0;  // below 1 only where the material blends
    double metallic = 0.0, roughness = 1.0;
    double occlusion = 1.0;
    double transmission = 0.0, thickness = 0.0;  // metres
    glm::dvec3 emitted{0.0};
    double turn = 0.0;     // radians by which the normal turns across what the path stands for
    double covered = 0.0;  // half vectors that it covers: a disc's radius squared, in slopes
};

class World {
public:
    // What is referred to must outlive it. Throws std::invalid_argument for images without texels.
    World(const Scene& scene, const Pose& pose, const MaterialBindings& materials,
          const Effects& effects);
    ~World();
    World(const World&) = delete;
    World& operator=(const World&) = delete;

    const glm::dvec3& origin() const { return origin_; }  // world; the middle of what can be met
    double diagonal() const { return diagonal_; }         // metres, of what can be met
    std::size_t triangleCount() const { return triangles_.size(); }

    // The nearest surface. Sides that are not drawn and holes of masks are not met.
    std::optional<Hit> nearest(const Ray& ray) const;
    // Whether anything at all is met.
    bool blocked(const Ray& ray) const;
    // Whether rays may go on behind what they meet: something blends or transmits.
    bool anyClear() const { return anyClear_; }
    bool emits() const { return emission_; }

    Point pointAt(const Hit& hit, const glm::dvec3& along) const;
    // Radians by which the normal turns on the way over `width` metres across the ray: the side of
    // a square as large as what the normals pass over.
    double turnAcross(const Hit& hit, const Point& point, const glm::dvec3& along,
                      double width) const;

    // A ray from a point of a surface, beside it on the side that it goes to.
    static Ray leaving(const Point& point, const glm::dvec3& along);

    struct Triangle {
        glm::vec3 a{0.0f};
        std::uint32_t firstIndex = 0;  // into Scene::indices
        glm::vec3 b{0.0f};
        std::uint32_t surface = 0;
        glm::vec3 c{0.0f};
        // Which side rays meet: 1 the one that sees a, b, c turn counter-clockwise, -1 the other,
        // 0 both.
        std::int32_t side = 0;
    };
    const std::vector<Triangle>& triangles() const { return triangles_; }
    const Surface& surfaceOf(const Triangle& triangle) const { return surfaces_[triangle.surface]; }
    const Material& materialOf(const Surface& surface) const {
        return materials_.material(scene_, surface.material);
    }

    // Whether a hit counts; for Embree.
    bool meets(std::uint32_t triangle, double weightB, double weightC, bool seenTurning) const;

private:
    // Of each instance.
    struct Placing {
        glm::dmat4 worldFromMesh{1.0};  // less the origin
        glm::dmat3 normalFromMesh{1.0};
        double scale = 1.0;    // metres for a metre of the mesh
        double turning = 1.0;  // -1: mirrored, so that fronts turn clockwise
    };
    void gather();
    void addSurface(std::uint32_t surface);

    MeshVertices verticesIn(const Surface& surface) const {
        return verticesOf(scene_, pose_, scene_.meshes[scene_.instances[surface.instance].mesh]);
    }

    const Scene& scene_;
    const Pose& pose_;
    const MaterialBindings& materials_;
    bool emission_ = true, refraction_ = true;
    std::vector<Surface> surfaces_;
    std::vector<Placing> placings_;
    std::vector<Triangle> triangles_;
    glm::dvec3 origin_{0.0};
    double diagonal_ = 1.0;
    bool anyClear_ = false;

    struct Tree;  // Embree's
    std::unique_ptr<Tree> tree_;
};

}  // namespace clerestory::reference
