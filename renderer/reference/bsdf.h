// The BSDF of opaque surfaces: a microfacet lobe over a diffuse lobe, mixed as in glTF 2.0
// (appendix B), with exact Fresnel for dielectrics. Directions are unit; "local": z is the shading
// normal. Densities are per steradian.
#pragma once

#include "reference/scene_geometry.h"

namespace clerestory::reference {

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

    // Reflectance of a microfacet at this cosine.
    glm::dvec3 fresnel(double cosine) const;

    // A direction of the specular lobe, sampled from the visible normals.
    struct SpecularSample {
        glm::dvec3 direction{0.0, 0.0, 1.0};  // local
        glm::dvec3 weight{0.0};               // lobe * cosine / pdf; 0 below the surface
        // Factor of the diffuse lobe. Its expectation is 1 - the specular albedo, so that energy is
        // conserved.
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
    glm::dvec3 microfacetLobe(const glm::dvec3& l, double alpha, double discRadius2) const;

    Frame frame_;
    glm::dvec3 v_;
    double alpha_ = 0.0, metallic_ = 0.0;
    double ior_ = 1.5, f0OfIor_ = 0.04, f90_ = 1.0;
    glm::dvec3 dielectric_{0.04}, metal_{0.0}, diffuse_{0.0}, f0_{0.04};
};

}  // namespace clerestory::reference
