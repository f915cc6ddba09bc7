// Light sources of the path tracer: punctual lights (KHR_lights_punctual and the environment's
// sun), emissive triangles, and an environment map as a light.
#pragma once

#include "reference/scene_geometry.h"
#include "scene/environment.h"

#include <vector>

namespace clerestory::reference {

struct PunctualLight {
    LightKind kind = LightKind::point;
    glm::dvec3 position{0.0};  // relative to SceneGeometry::origin()
    glm::dvec3 toLight{0.0, 1.0,
                       0.0};    // directional: towards the light; spot: opposite to its axis
    glm::dvec3 intensity{0.0};  // lux if directional, else candela
    double range = 0.0;         // metres; 0: unlimited
    double cosInner = 1.0, cosOuter = 0.0;
    double radius = 0.0;  // as Light::radius
};

std::vector<PunctualLight> collectPunctualLights(const std::vector<Light>& lights, const Pose& pose,
                                                 const glm::dvec3& origin,
                                                 const EnvironmentMap& environment,
                                                 const glm::dmat3& worldFromMap,
                                                 double environmentIntensity);

// A punctual light as seen from a position.
struct LightSample {
    glm::dvec3 toLight{0.0};     // unit
    double distance = 0.0;       // infinite for directional lights
    glm::dvec3 irradiance{0.0};  // unoccluded, on a surface that faces the light
};
// Of the centre.
LightSample evalLight(const PunctualLight& light, const glm::dvec3& position);
// Turned to a point of the disc that the light shows to the position, uniform in area over u, 0..1.
LightSample towardsDisc(const PunctualLight& light, LightSample centre, const glm::dvec2& u);

// All emissive triangles, sampled in proportion to the flux of the untextured material.
class Emitters {
public:
    explicit Emitters(const SceneGeometry& geometry);

    bool empty() const { return triangles_.empty(); }

    struct Sample {
        std::uint32_t triangle = kNoTriangle;
        double weightB = 0.0, weightC = 0.0;  // barycentric
        glm::dvec3 position{0.0};
    };
    Sample sample(double uTriangle, const glm::dvec2& uPosition) const;

    // Density per steradian of sampling the position that a ray hits on the triangle at this
    // distance.
    double pdf(std::uint32_t triangle, const glm::dvec3& direction, double distance) const;

private:
    struct Entry {
        std::uint32_t triangle = 0;
        double cdf = 0.0;  // of the entries before this one
        double pdf = 0.0;  // per square metre
    };
    std::vector<Entry> triangles_;  // by triangle index
    const SceneGeometry& geometry_;
};

class EnvironmentLight {
public:
    // map must outlive this object. intensity: factor on its radiance.
    EnvironmentLight(const EnvironmentMap& map, const glm::dmat3& worldFromMap, double intensity);

    // Radiance from a direction (world, unit) without the map's sun; bilinear, also across the
    // edges of faces.
    glm::dvec3 radiance(const glm::dvec3& direction) const;

    // Unoccluded irradiance / pi for a unit normal. Exact except for bilinear interpolation: within
    // 5e-4 of the map's maximum. Requires prepareIrradiance().
    glm::dvec3 irradianceOverPi(const glm::dvec3& normal) const;

    // A direction sampled in proportion to luminance, and its density per steradian; density 0 if
    // the map is black. Both require prepareSampling().
    struct Sample {
        glm::dvec3 direction{0.0, 1.0, 0.0};
        double pdf = 0.0;
    };
    Sample sample(const glm::dvec2& u) const;
    double pdf(const glm::dvec3& direction) const;

    void prepareIrradiance();
    void prepareSampling();

private:
    const EnvironmentMap& map_;
    glm::dmat3 worldFromMap_, mapFromWorld_;
    double intensity_;
    std::vector<glm::dvec3> irradiance_;  // six faces of (kIrradianceCells + 1)^2 grid points
    std::uint32_t cells_ = 0;             // sampling cells along a face's edge
    std::vector<double> cdf_;  // probability of all cells before one; the last entry is 1
};

}  // namespace clerestory::reference
