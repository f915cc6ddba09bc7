// Formulae of layers over an opaque surface, as KHR_materials_sheen and _iridescence define them.
// Without the renderer's fits: albedos and spectra are summed.
#pragma once

#include "reference/scene_geometry.h"

#include <glm/glm.hpp>

namespace clerestory::reference {

// The lobe of white fibres, without the cosine to the light, and its directional albedo. Cosines
// with the normal, of the light, the eye and the half vector.
double sheenLobe(double nDotL, double nDotV, double nDotH, double roughness);
double sheenAlbedo(double nDotV, double roughness);

// Reflectance of a base under a thin film, seen from air: Airy's formula for both polarisations,
// summed over the visible spectrum for each primary. The base has the real index of refraction that
// reflects f0 at normal incidence. thickness: nanometres.
glm::dvec3 filmReflectance(double cosine, double filmIor, double thickness, const glm::dvec3& f0);

// The reflectance of a face of glass at this point, whose own is `fresnel`.
glm::dvec3 underFilm(const SurfaceInteraction& point, double cosine, double fresnel);

}  // namespace clerestory::reference
