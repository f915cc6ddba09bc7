#include "light/open_light.h"

#include "light/division.h"

#include <algorithm>
#include <array>

namespace clerestory::light {
namespace {

// Values at vertices. Instances beyond them have one value: that of the mean.
constexpr std::size_t kMaxValues = 8'000'000;

// Irradiance over pi by normal.
class OpenSky {
public:
    OpenSky(const EnvironmentMap& map, float intensity) : harmonics_(map.harmonics) {
        for (glm::vec3& c : harmonics_) c *= intensity;
        slope_ = {luminance(harmonics_[3]), luminance(harmonics_[1]), luminance(harmonics_[2])};
    }

    glm::vec3 irradiance(const glm::vec3& normal) const {
        return harmonicsAlong(harmonics_, normal);
    }
    LightAtVertex mean() const {
        const float scale = 1.0f / std::max(luminance(harmonics_[0]), 1e-20f);
        return {.irradiance = harmonics_[0], .turned = glm::vec4(slope_ * scale, 1.0f)};
    }
    // Bumps turn the normal a little; the factor is 1 at the vertex' own.
    LightAtVertex oneSided(const glm::vec3& normal) const {
        LightAtVertex light{.irradiance = irradiance(normal)};
        const float scale = 1.0f / std::max(luminance(light.irradiance), 1e-20f);
        const glm::vec3 turned = slope_ * scale;
        light.turned = glm::vec4(turned, 1.0f - glm::dot(turned, normal));
        return light;
    }
    LightAtVertex twoSided(const glm::vec3& normal) const {
        const glm::vec4 all(0.0f, 0.0f, 0.0f, 1.0f);
        return ofBothSides({irradiance(normal), all}, {irradiance(-normal), all}, normal,
                           glm::vec3(0.0f));
    }

private:
    std::array<glm::vec3, 9> harmonics_;
    glm::vec3 slope_;  // of the luminance
};

}  // namespace

LightAtVertex lightInTheOpen(const EnvironmentMap& environment, float intensity) {
    return OpenSky(environment, intensity).mean();
}

SurfaceLight openLight(const OpenLightInput& input) {
    const Scene& scene = *input.scene;
    const OpenSky sky(input.environment, input.environmentIntensity);
    SurfaceLight light{.key = input.key, .scene = input.scene};
    light.firstOfInstance.assign(scene.instances.size(), kNoLight);
    light.values.push_back(packed(sky.mean()));
    const std::vector<bool> moves = instancesThatMove(scene);
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        const Mesh& mesh = scene.meshes[instance.mesh];
        const Material& material = input.materials.material(
            scene, input.materials.materialOf(scene, static_cast<Index>(i)));
        if (moves[i] || material.unlit || mesh.primitive != Primitive::triangles) continue;
        const VertexRange range = vertexRange(scene, mesh);
        if (light.values.size() + range.count > kMaxValues) continue;
        light.firstOfInstance[i] =
            static_cast<std::int32_t>(light.values.size()) - static_cast<std::int32_t>(range.first);
        const glm::dmat3 normals =
            input.mapFromWorld * normalMatrix(glm::dmat3(input.pose.worldFromNode[instance.node]));
        for (std::uint32_t v = range.first; v < range.first + range.count; ++v) {
            const glm::dvec3 n = normals * glm::dvec3(scene.vertices[v].normal);
            const double length = glm::length(n);
            const glm::vec3 normal =
                length > 0.0 ? glm::vec3(n / length) : glm::vec3(0.0f, 1.0f, 0.0f);
            light.values.push_back(
                packed(material.doubleSided ? sky.twoSided(normal) : sky.oneSided(normal)));
        }
    }
    light.values.shrink_to_fit();
    if (input.emitters) light.emitters.resize(light.values.size());
    return light;
}

}  // namespace clerestory::light
