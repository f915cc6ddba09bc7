// What an opaque point does with light: a specular lobe of facets over a diffuse rest, as glTF 2.0
// mixes them (appendix B), with exact Fresnel for what is not metal.
#pragma once

#include "reference/world.h"

namespace clerestory::reference {

// A direction above the surface, local, chosen as often as a diffuse surface sends light there; and
// that choice's density per steradian.
glm::dvec3 cosineWeighted(const glm::dvec2& random);
double cosineDensity(const glm::dvec3& l);

class Lobes {
public:
    // toEye: unit, on the normal's side.
    Lobes(const Point& point, const glm::dvec3& toEye);

    const Frame& frame() const { return frame_; }
    const glm::dvec3& toEye() const { return v_; }  // local
    double alpha() const { return alpha_; }
    bool mirror() const;                                    // the lobe is too narrow to be one
    const glm::dvec3& diffuse() const { return diffuse_; }  // albedo of what is not metal

    // Of a facet that is met at this cosine.
    glm::dvec3 fresnel(double cosine) const;

    // A facet chosen as the eye sees them: where it sends the eye's ray, and what it returns of the
    // light from there: 0 where that is below the surface. What it does not return is left to the
    // diffuse lobe; the mean of `rest` is 1 - the lobe's albedo, so none of the light is lost or
    // made.
    struct Facet {
        glm::dvec3 towards{0.0, 0.0, 1.0};  // local
        glm::dvec3 weight{0.0};
        double rest = 1.0;
    };
    Facet facet(const glm::dvec2& random) const;

    // Reflected radiance per irradiance from l (local, above the surface), of each lobe.
    glm::dvec3 specularOf(const glm::dvec3& l) const;
    double densityOf(const glm::dvec3& l) const;  // of facet() choosing it, per steradian

    // The same under a lamp without size: the lobe is not narrower than roughness 0.045, and the
    // diffuse rest is what the one facet that mirrors the lamp leaves.
    // covered: see facetMean(), of all that the path stands for.
    glm::dvec3 underLamp(const glm::dvec3& l, double diffuseShare, double covered = 0.0) const;

private:
    glm::dvec3 lobe(const glm::dvec3& l, double alpha, double covered) const;

    Frame frame_;
    glm::dvec3 v_;
    double alpha_ = 0.0, metallic_ = 0.0;
    double ior_ = 1.5, f0OfIor_ = 0.04, grazing_ = 1.0;
    glm::dvec3 dielectric_{0.04}, metal_{0.0}, diffuse_{0.0}, f0_{0.04};
};

}  // namespace clerestory::reference
