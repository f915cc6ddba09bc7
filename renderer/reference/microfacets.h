// The GGX microfacet distribution with height-correlated masking (Walter 2007, Heitz 2014), its
// albedo, and cosine-weighted directions.
//
// Directions are unit and local: z is the shading normal. alpha is roughness squared, or two
// numbers: along x and along y; densities are per steradian.
#pragma once

#include <glm/glm.hpp>

namespace clerestory::reference {

// Narrower lobes (below roughness 0.03) are treated as mirrors.
inline constexpr double kMinReferenceAlpha = 1e-3;
// Of the highlights of punctual lights: the renderer's kMinRoughness, squared.
inline constexpr double kMinPunctualAlpha = 0.045 * 0.045;

// GGX density of microfacet normals.
double normalDistribution(const glm::dvec3& normal, const glm::dvec2& alpha);
inline double normalDistribution(const glm::dvec3& normal, double alpha) {
    return normalDistribution(normal, glm::dvec2(alpha));
}

// Mean of normalDistribution() over a disc about the normal, in slope space; discRadius2: its
// squared radius. GGX slopes are distributed like the irradiance from a parallel plane at height
// alpha, so the integral is the form factor of a disc.
double meanNormalDistribution(const glm::dvec3& normal, double alpha, double discRadius2);

// Smith's masking G1(v) and height-correlated masking-shadowing G2(v, l).
double masking(const glm::dvec3& v, const glm::dvec2& alpha);
double maskingShadowing(const glm::dvec3& v, const glm::dvec3& l, const glm::dvec2& alpha);
inline double masking(const glm::dvec3& v, double alpha) {
    return masking(v, glm::dvec2(alpha));
}
inline double maskingShadowing(const glm::dvec3& v, const glm::dvec3& l, double alpha) {
    return maskingShadowing(v, l, glm::dvec2(alpha));
}

// A microfacet normal sampled from those visible from v (v.z >= 0; Dupuy and Benyoub 2023), and its
// density.
glm::dvec3 sampleVisibleNormal(const glm::dvec3& v, const glm::dvec2& alpha, const glm::dvec2& u);
double visibleNormalPdf(const glm::dvec3& v, const glm::dvec3& normal, const glm::dvec2& alpha);

// Density of the reflected direction l when the normal comes from sampleVisibleNormal().
double reflectionPdf(const glm::dvec3& v, const glm::dvec3& l, const glm::dvec2& alpha);
inline glm::dvec3 sampleVisibleNormal(const glm::dvec3& v, double alpha, const glm::dvec2& u) {
    return sampleVisibleNormal(v, glm::dvec2(alpha), u);
}
inline double visibleNormalPdf(const glm::dvec3& v, const glm::dvec3& normal, double alpha) {
    return visibleNormalPdf(v, normal, glm::dvec2(alpha));
}
inline double reflectionPdf(const glm::dvec3& v, const glm::dvec3& l, double alpha) {
    return reflectionPdf(v, l, glm::dvec2(alpha));
}

// The microfacet normal that refracts between v and l (l.z < 0). eta: index on the side of l / on
// that of v.
glm::dvec3 refractingNormal(const glm::dvec3& v, const glm::dvec3& l, double eta);
// Density of the refracted direction l when the normal comes from sampleVisibleNormal(), of what
// is not reflected (Walter 2007, equation 17).
double refractionPdf(const glm::dvec3& v, const glm::dvec3& l, double alpha, double eta);

// Directional albedo of the lobe for perfectly reflecting microfacets, single scattering only.
// Interpolated from a table that is computed at first use; error below 2e-3.
double singleScatterAlbedo(double cosine, double alpha);

// Energy compensation for multiple scattering; f0: reflectance at normal incidence (Turquin 2019).
glm::dvec3 multipleScatterFactor(const glm::dvec3& f0, double cosine, double alpha);

// A cosine-weighted local direction of the upper hemisphere, and its density.
glm::dvec3 sampleCosineHemisphere(const glm::dvec2& u);
double cosineHemispherePdf(const glm::dvec3& l);

}  // namespace clerestory::reference
