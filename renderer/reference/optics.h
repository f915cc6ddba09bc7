// Smooth interfaces: exact Fresnel reflectance for both polarisations (Born and Wolf, Principles of
// Optics, 1.5.2), refraction, thin panes with all internal reflections, and absorption.
#pragma once

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

}  // namespace clerestory::reference
