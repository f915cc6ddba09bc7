#include "reference/optics.h"

#include "reference/vectors.h"

#include <initializer_list>

namespace clerestory::reference {

double refractedCosine(double cosine, double eta) {
    const double c = std::clamp(cosine, 0.0, 1.0);
    // eta^2 cosine'^2 = eta^2 - sin^2
    const double squared = (eta - 1.0) * (eta + 1.0) + c * c;
    return squared < 0.0 ? -1.0 : std::min(1.0, std::sqrt(squared) / eta);
}

PolarisedReflectance fresnel(double cosine, double eta) {
    if (std::abs(eta - 1.0) < 1e-9) return {0.0, 0.0};
    const double in = std::clamp(cosine, 0.0, 1.0);
    const double out = refractedCosine(in, eta);
    if (out < 0.0) return {1.0, 1.0};
    // The divisors are 0 only at the critical angle and grazing, where reflection is total.
    const double sDivisor = in + eta * out, pDivisor = eta * in + out;
    if (!(sDivisor > 0.0) || !(pDivisor > 0.0)) return {1.0, 1.0};
    const double s = (in - eta * out) / sDivisor, p = (eta * in - out) / pDivisor;
    return {s * s, p * p};
}

glm::dvec3 refracted(const glm::dvec3& incident, const glm::dvec3& normal, double eta) {
    const double c = -glm::dot(incident, normal);
    const double out = std::max(refractedCosine(c, eta), 0.0);
    return unitOr((incident + normal * c) / eta - normal * out, incident);
}

PaneCoefficients paneCoefficients(double cosine, double ior, const glm::dvec3& transmittance) {
    const PolarisedReflectance f = fresnel(cosine, ior);
    PaneCoefficients sum;
    for (const double r : {f.s, f.p}) {
        for (int i = 0; i < 3; ++i) {
            const double a = std::clamp(transmittance[i], 0.0, 1.0);
            const double divisor = 1.0 - r * r * a * a;
            const double t = divisor > 1e-12 ? (1.0 - r) * (1.0 - r) * a / divisor : 0.0;
            sum.transmitted[i] += 0.5 * t;
            sum.reflected[i] += 0.5 * r * (1.0 + a * t);
        }
    }
    return sum;
}

glm::dvec3 beerLambert(const glm::dvec3& color, double attenuationDistance, double distance) {
    if (!(attenuationDistance > 0.0) || !(distance > 0.0)) return glm::dvec3(1.0);
    const double ratio = distance / attenuationDistance;
    return glm::pow(glm::clamp(color, 0.0, 1.0), glm::dvec3(ratio));
}

}  // namespace clerestory::reference
