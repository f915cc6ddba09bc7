// The BSDF of opaque surfaces: a microfacet lobe over a diffuse lobe, mixed as in glTF 2.0
// (appendix B), with exact Fresnel for dielectrics.
//
// Directions are unit; "local": z is the shading normal.
#pragma once

#include "reference/microfacets.h"
#include "reference/optics.h"
#include "reference/scene_geometry.h"

#include <glm/glm.hpp>

namespace clerestory::reference {

class Bsdf {
public:
    // toEye: unit, on the normal's side.
    Bsdf(const SurfaceInteraction& point, const glm::dvec3& toEye);

    const Frame& frame() const { return frame_; }
    const glm::dvec3& toEye() const { return v_; }  // local
    double alpha() const { return alpha_; }
    bool isMirror() const;  // the lobe is a delta distribution
    // Directions of the lobe rarely meet the image of a light in a mirror.
    bool isWide() const { return alpha_ > 0.2; }
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
    // The diffuse lobe alone.
    glm::dvec3 evalDiffuse(const glm::dvec3& l) const;

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
