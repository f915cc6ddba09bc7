// Light at the border of two clear media, from the amplitudes of its two polarisations (Born and
// Wolf, Principles of Optics, 1.5.2), and through a pane with all bounces between its faces.
#pragma once

#include <glm/glm.hpp>

namespace clerestory::reference {

// Reflectances of light whose electric field lies across (s) and in (p) the plane of incidence.
struct Polarised {
    double s = 0.0, p = 0.0;
    double mean() const { return 0.5 * (s + p); }
};

// cosine: of the ray and the normal it comes from, 0..1. eta: index behind the border / index in
// front of it, above 0. Both 1 where nothing gets through; both 0 for eta 1.
Polarised fresnel(double cosine, double eta);

// Cosine behind the border; negative where nothing gets through.
double refractedCosine(double cosine, double eta);

// The ray behind the border, unit; normal: against the ray. Only where refractedCosine() is not
// negative.
glm::dvec3 refracted(const glm::dvec3& incident, const glm::dvec3& normal, double eta);

// Shares of the light that a pane sends back and lets through: the sum of the series of bounces
// between two parallel faces, for each polarisation, added without interference (erratum G3).
struct PaneShares {
    glm::dvec3 reflected{0.0}, transmitted{0.0};
};
// clear: what one way from face to face leaves of the light, 0..1 per channel.
PaneShares paneShares(double cosine, double ior, const glm::dvec3& clear);

// What a way (metres) through a medium leaves: color^(way / distance); distance 0: all of it.
glm::dvec3 absorbed(const glm::dvec3& color, double attenuationDistance, double way);

}  // namespace clerestory::reference
