#include "reference/layer_choice.h"

#include "reference/bsdf.h"
#include "reference/layers.h"

#include <algorithm>

namespace clerestory::reference {
namespace {

constexpr double kClearcoatIor = 1.5;

double clampedProbability(double p) {
    return std::clamp(p, 0.1, 0.9);
}

}  // namespace

double belowClearcoat(const SurfaceInteraction& point, const glm::dvec3& toEye) {
    const double cosine = glm::dot(point.layers.clearcoatNormal, toEye);
    return 1.0 - point.layers.clearcoat * fresnel(cosine, kClearcoatIor).mean();
}

void chooseLayer(SurfaceInteraction& point, const glm::dvec3& toEye, Sampler& sampler,
                 glm::dvec3& throughput) {
    const SurfaceInteraction::Layers& layers = point.layers;
    if (layers.clearcoat > 0.0) {
        const double alpha = layers.clearcoatRoughness * layers.clearcoatRoughness;
        glm::dvec3 v = Frame(layers.clearcoatNormal).toLocal(toEye);
        v.z = std::max(v.z, 1e-6);
        const glm::dvec3 facet = alpha < kMinReferenceAlpha
                                     ? glm::dvec3(0.0, 0.0, 1.0)
                                     : sampleVisibleNormal(v, alpha, sampler.get2D());
        const double reflected =
            layers.clearcoat * fresnel(glm::dot(v, facet), kClearcoatIor).mean();
        const double probability = clampedProbability(reflected);
        if (sampler.get1D() < probability) {
            throughput *= layers.clearcoat / probability;
            point.normal = layers.clearcoatNormal;
            point.roughness = layers.clearcoatRoughness;
            point.metallic = 0.0;
            point.baseColor = glm::dvec3(0.0);
            point.ior = kClearcoatIor;
            point.specular = 1.0;
            point.specularColor = glm::dvec3(1.0);
            point.lobe = SurfaceInteraction::Lobe::clearcoat;
            point.layers = {};
            return;
        }
        throughput *= (1.0 - reflected) / (1.0 - probability);
    }
    if (const double strength = greatest(layers.sheen); strength > 0.0) {
        const double reflected =
            strength * sheenAlbedo(glm::dot(point.normal, toEye), layers.sheenRoughness);
        const double probability = clampedProbability(reflected);
        if (sampler.get1D() < probability) {
            throughput /= probability;
            point.baseColor = layers.sheen;
            point.roughness = layers.sheenRoughness;
            point.metallic = 0.0;
            point.lobe = SurfaceInteraction::Lobe::sheen;
            point.layers = {};
            return;
        }
        throughput *= (1.0 - reflected) / (1.0 - probability);
    }
    const double share = layers.throughShare * (1.0 - point.metallic);
    if (share > 0.0) {
        const double probability = clampedProbability(share);
        if (sampler.get1D() < probability) {
            const Bsdf above(point, toEye);
            throughput *= share * above.sampleSpecular(sampler.get2D()).diffuseFactor / probability;
            point.normal = -point.normal;
            point.geometricNormal = -point.geometricNormal;
            point.baseColor = layers.through;
            point.metallic = point.specular = 0.0;
            point.lobe = SurfaceInteraction::Lobe::transmitted;
            point.layers = {};
            return;
        }
        throughput /= 1.0 - probability;
    }
}

}  // namespace clerestory::reference
