#include "reference/fresnel.h"

#include "reference/vectors.h"

namespace clerestory::reference {

double refractedCosine(double cosine, double eta) {
    const double c = std::clamp(cosine, 0.0, 1.0);
    // eta^2 cosine'^2 = eta^2 - sin^2
    const double squared = (eta - 1.0) * (eta + 1.0) + c * c;
    return squared < 0.0 ? -1.0 : std::min(1.0, std::sqrt(squared) / eta);
}

Polarised fresnel(double cosine, double eta) {
    if (std::abs(eta - 1.0) < 1e-9) return {0.0, 0.0};
    const double in = std::clamp(cosine, 0.0, 1.0);
    const double out = refractedCosine(in, eta);
    if (out < 0.0) return {1.0, 1.0};
    // Both divisors are 0 at once grazing and critical alone, where everything is reflected.
    const double across = in + eta * out, within = eta * in + out;
    if (!(across > 0.0) || !(within > 0.0)) return {1.0, 1.0};
    const double s = (in - eta * out) / across, p = (eta * in - out) / within;
    return {s * s, p * p};
}

glm::dvec3 refracted(const glm::dvec3& incident, const glm::dvec3& normal, double eta) {
    const double c = -glm::dot(incident, normal);
    const double out = std::max(refractedCosine(c, eta), 0.0);
    return unitOr((incident + normal * c) / eta - normal * out, incident);
}

PaneShares paneShares(double cosine, double ior, const glm::dvec3& clear) {
    const Polarised f = fresnel(cosine, ior);
    PaneShares shares;
    for (const double r : {f.s, f.p}) {
        for (int i = 0; i < 3; ++i) {
            const double a = std::clamp(clear[i], 0.0, 1.0);
            const double left = 1.0 - r * r * a * a;
            const double t = left > 1e-12 ? (1.0 - r) * (1.0 - r) * a / left : 0.0;
            shares.transmitted[i] += 0.5 * t;
            shares.reflected[i] += 0.5 * r * (1.0 + a * t);
        }
    }
    return shares;
}

glm::dvec3 absorbed(const glm::dvec3& color, double attenuationDistance, double way) {
    if (!(attenuationDistance > 0.0) || !(way > 0.0)) return glm::dvec3(1.0);
    const double ratio = way / attenuationDistance;
    return glm::pow(glm::clamp(color, 0.0, 1.0), glm::dvec3(ratio));
}

}  // namespace clerestory::reference
