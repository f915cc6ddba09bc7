// How a surface scatters light: exact Fresnel reflectance for both polarisations (Born and Wolf,
// Principles of Optics, 1.5.2), thin panes with all internal reflections, the GGX microfacet
// distribution with height-correlated masking (Walter 2007, Heitz 2014), and the BSDF of opaque
// surfaces: a microfacet lobe over a diffuse lobe, mixed as in glTF 2.0 (appendix B), with exact
// Fresnel for dielectrics.
//
// Directions are unit; "local": z is the shading normal. alpha is roughness squared, or two
// numbers: along x and along y; densities are per steradian.
#pragma once

#include "reference/scene_geometry.h"

#include <glm/glm.hpp>

namespace clerestory::reference {

// s: electric field perpendicular to the plane of incidence, p: parallel.
struct PolarisedReflectance {
    double s = 0.0, p = 0.0;
    double mean() const { return 0.5 * (s + p); }
};

// cosine: of the angle of incidence, 0..1. eta: index of the transmitting medium / index of the
// incident medium, above 0. Total internal reflection gives 1; eta 1 gives 0.
PolarisedReflectance fresnel(double cosine, double eta);

// Cosine of the angle of refraction; negative for total internal reflection.
double refractedCosine(double cosine, double eta);

// The refracted direction, unit. normal: on the side of incidence. Requires refractedCosine() >= 0.
glm::dvec3 refracted(const glm::dvec3& incident, const glm::dvec3& normal, double eta);

// Reflectance and transmittance of a pane: the sum over all internal reflections between two
// parallel faces, for each polarisation, without interference (erratum G3).
struct PaneCoefficients {
    glm::dvec3 reflected{0.0}, transmitted{0.0};
};
// transmittance: of one crossing from face to face, 0..1 per channel.
PaneCoefficients paneCoefficients(double cosine, double ior, const glm::dvec3& transmittance);

// Transmittance of a medium over `distance` metres: color^(distance / attenuationDistance);
// attenuationDistance 0: no absorption.
glm::dvec3 beerLambert(const glm::dvec3& color, double attenuationDistance, double distance);

// Narrower lobes (below roughness 0.03) are treated as mirrors.
inline constexpr double kMinReferenceAlpha = 1e-3;

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

// Directional albedo of the lobe for perfectly reflecting microfacets, single scattering only.
// Interpolated from a table that is computed at first use; error below 2e-3.
double singleScatterAlbedo(double cosine, double alpha);

// Energy compensation for multiple scattering; f0: reflectance at normal incidence (Turquin 2019).
glm::dvec3 multipleScatterFactor(const glm::dvec3& f0, double cosine, double alpha);

// A cosine-weighted local direction of the upper hemisphere, and its density.
glm::dvec3 sampleCosineHemisphere(const glm::dvec2& u);
double cosineHemispherePdf(const glm::dvec3& l);

class Bsdf {
public:
    // toEye: unit, on the normal's side.
    Bsdf(const SurfaceInteraction& point, const glm::dvec3& toEye);

    const Frame& frame() const { return frame_; }
    const glm::dvec3& toEye() const { return v_; }  // local
    double alpha() const { return alpha_; }
    bool isMirror() const;                                  // the lobe is a delta distribution
    const glm::dvec3& diffuse() const { return diffuse_; }  // albedo of the dielectric part

    // Reflectance of a microfacet at this cosine. What a surface mirrors leaves its face, so that
    // the half vector of the eye and any such direction has a least cosine: sin(e / 2), e the
    // elevation of the eye over the face.
    glm::dvec3 fresnel(double cosine) const;

    // A direction of the specular lobe, sampled from the visible normals.
    struct SpecularSample {
        glm::dvec3 direction{0.0, 0.0, 1.0};  // local
        glm::dvec3 weight{0.0};               // lobe * cosine / pdf; 0 below the surface
        // Factor of the diffuse lobe. Its expectation is 1 - the specular albedo of the dielectric
        // part, so that energy is conserved.
        double diffuseFactor = 1.0;
    };
    SpecularSample sampleSpecular(const glm::dvec2& u) const;

    // The specular lobe without the cosine, and the density of sampleSpecular(). l: local.
    glm::dvec3 evalSpecular(const glm::dvec3& l) const;
    double specularPdf(const glm::dvec3& l) const;

    // Both lobes for a punctual light: the specular lobe has at least roughness 0.045, and the
    // diffuse lobe has what the microfacet that reflects the light leaves. discRadius2: see
    // meanNormalDistribution().
    glm::dvec3 evalPunctual(const glm::dvec3& l, double diffuseScale,
                            double discRadius2 = 0.0) const;

private:
    double clampedCosine(double cosine) const;
    glm::dvec3 dielectricFresnel(double cosine) const;  // of the dielectric alone
    glm::dvec3 metalFresnel(double cosine) const;
    glm::dvec3 underFilm(const glm::dvec3& base, const glm::dvec3& f0, double cosine) const;
    glm::dvec3 sheenLobe(const glm::dvec3& l) const;
    // With what several bounces between microfacets add (Turquin 2019).
    glm::dvec3 scatteredFresnel(double cosine, double alpha) const;
    glm::dvec3 microfacetLobe(const glm::dvec3& l, double alpha, double discRadius2) const;

    Frame frame_;
    glm::dvec3 v_;
    double leastCosine_ = 0.0;
    double alpha_ = 0.0, metallic_ = 0.0;
    glm::dvec2 alphas_{0.0};        // along the grain and across it
    double scatteringAlpha_ = 0.0;  // their mean: of what several bounces add
    bool isSheen_ = false;
    double sheenRoughness_ = 0.0;
    double film_ = 0.0, filmIor_ = 1.0, filmThickness_ = 0.0;
    double ior_ = 1.5, f0OfIor_ = 0.04, f90_ = 1.0;
    glm::dvec3 dielectric_{0.04}, metal_{0.0}, diffuse_{0.0};
};

}  // namespace clerestory::reference
