// The posed scene for ray tracing: its triangles in world space in an Embree hierarchy, and the
// material's values at a hit.
#pragma once

#include "plan/request/frame_request.h"
#include "reference/embree_bvh.h"
#include "reference/ray.h"
#include "reference/vectors.h"
#include "scene/classification.h"
#include "scene/flat_mirrors.h"
#include "scene/geometry.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <optional>
#include <vector>

namespace clerestory::reference {

// Geometry and material at a hit.
struct SurfaceInteraction {
    glm::dvec3 position{0.0};
    glm::dvec3 geometricNormal{0.0};  // unit; faces the ray's origin
    glm::dvec3 normal{
        0.0};           // shading normal: interpolated, with the normal map; faces the ray's origin
    bool front = true;  // the ray comes from the front side
    double maxCoordinate = 0.0;  // greatest absolute coordinate of the triangle's corners
    std::uint32_t triangle = 0;
    Index instance = 0;
    const Surface* surface = nullptr;
    const Material* material = nullptr;
    glm::dvec3 baseColor{1.0};
    double coverage = 1.0;  // below 1 only for AlphaMode::blend
    double metallic = 0.0, roughness = 1.0;
    double occlusion = 1.0;
    double transmission = 0.0, thickness = 0.0;  // metres
    double ior = 1.5, specular = 1.0;
    glm::dvec3 specularColor{1.0};
    // What of the surface scatters: all below its layers, or one of them; see chooseLayer().
    enum class Lobe { base, clearcoat, sheen, transmitted };
    Lobe lobe = Lobe::base;
    // As in shaders/include/material_point.glsl.
    struct Layers {
        double clearcoat = 0.0, clearcoatRoughness = 0.0;
        glm::dvec3 clearcoatNormal{0.0, 0.0, 1.0};
        glm::dvec3 sheen{0.0};
        double sheenRoughness = 0.0;
        double film = 0.0, filmIor = 1.3, filmThickness = 0.0;
        double anisotropy = 0.0;
        glm::dvec3 grain{1.0, 0.0, 0.0};
        glm::dvec3 through{0.0};
        double throughShare = 0.0;
    };
    Layers layers;
    glm::dvec3 emission{0.0};
    double normalSpread = 0.0;  // radians by which the normal varies over the pixel footprint
    double discRadius2 = 0.0;   // half vectors of the footprint: squared radius of a disc of slopes
};

class SceneGeometry {
public:
    // The arguments must outlive this object. Throws std::invalid_argument for images without
    // texels.
    SceneGeometry(const Scene& scene, const Pose& pose, const MaterialBindings& materials,
                  const Effects& effects);
    SceneGeometry(const SceneGeometry&) = delete;
    SceneGeometry& operator=(const SceneGeometry&) = delete;

    const glm::dvec3& origin() const { return origin_; }  // world; the centre of the bounds
    double diagonal() const { return diagonal_; }         // metres, of the bounds
    std::size_t triangleCount() const { return triangles_.size(); }

    // The nearest hit. Culled sides and texels below the alpha cutoff are ignored.
    std::optional<Hit> intersect(const Ray& ray) const { return bvh_->intersect(ray); }
    // Whether the ray hits anything.
    bool occluded(const Ray& ray) const { return bvh_->occluded(ray); }
    // Whether any material blends or transmits, so that rays may continue behind a hit.
    bool hasTransparency() const { return hasTransparency_; }
    bool emissionEnabled() const { return emission_; }

    SurfaceInteraction interactionAt(const Hit& hit, const glm::dvec3& direction) const;
    // Radians by which the normal varies over `width` metres across the ray: the square root of the
    // solid angle of the normals.
    double normalSpreadAcross(const Hit& hit, const SurfaceInteraction& point,
                              const glm::dvec3& direction, double width) const;

    // A ray that leaves the surface, its origin offset against self-intersection.
    static Ray spawnRay(const SurfaceInteraction& point, const glm::dvec3& direction);
    // The same towards another surface. It ends before it at any angle: both ends are offset.
    static Ray spawnRayTo(const SurfaceInteraction& point, const SurfaceInteraction& end);

    struct Triangle {
        glm::vec3 a{0.0f};
        std::uint32_t firstIndex = 0;  // into Scene::indices
        glm::vec3 b{0.0f};
        std::uint32_t surface = 0;
        glm::vec3 c{0.0f};
        // Which side rays hit: 1 the one from which a, b, c are counter-clockwise, -1 the other, 0
        // both.
        std::int32_t side = 0;
    };
    const std::vector<Triangle>& triangles() const { return triangles_; }
    const Surface& surfaceOf(const Triangle& triangle) const { return surfaces_[triangle.surface]; }
    const Material& materialOf(const Surface& surface) const {
        return materials_.material(scene_, surface.material);
    }

    // Those that throw punctual light onto other surfaces; relative to the origin.
    const std::vector<FlatMirror>& flatMirrors() const { return flatMirrors_; }
    const Surface& surfaceOf(const FlatMirror& mirror) const { return surfaces_[mirror.surface]; }

    // Whether a ray hits the triangle at this point: side and alpha mask.
    bool acceptsHit(std::uint32_t triangle, double weightB, double weightC,
                    bool counterClockwise) const;

private:
    struct InstanceTransform {
        glm::dmat4 worldFromMesh{1.0};  // relative to origin_
        glm::dmat3 normalFromMesh{1.0};
        double scale = 1.0;        // world metres per metre of the mesh
        double orientation = 1.0;  // -1: mirrored, so that front faces are clockwise
    };
    void collectTriangles();
    void addSurface(std::uint32_t surface);

    MeshVertices verticesIn(const Surface& surface) const {
        return verticesOf(scene_, pose_, scene_.meshes[scene_.instances[surface.instance].mesh]);
    }

    const Scene& scene_;
    const Pose& pose_;
    const MaterialBindings& materials_;
    bool emission_ = true, refraction_ = true, layers_ = true;
    std::vector<Surface> surfaces_;
    std::vector<FlatMirror> flatMirrors_;
    std::vector<InstanceTransform> transforms_;
    std::vector<Triangle> triangles_;
    glm::dvec3 origin_{0.0};
    double diagonal_ = 1.0;
    bool hasTransparency_ = false;

    std::optional<EmbreeBvh> bvh_;  // over triangles_; set by the constructor
};

}  // namespace clerestory::reference
