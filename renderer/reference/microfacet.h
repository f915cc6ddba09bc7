// Rough surfaces as many small mirrors: GGX with height-correlated shadowing (Walter 2007, Heitz
// 2014). Directions are unit and local: z is the normal. alpha: roughness squared.
#pragma once

#include <glm/glm.hpp>

namespace clerestory::reference {

// Lobes narrower than this (roughness 0.03) are mirrors.
inline constexpr double kMinReferenceAlpha = 1e-3;

// Density of facet normals per steradian.
double facetDensity(const glm::dvec3& normal, double alpha);

// Its mean over a disc about the normal; covered: the disc's radius squared, in slopes. Slopes of
// facets are spread as the light that a plane gets from a parallel one at height alpha, so the sum
// over a disc is the form factor of a disc.
double facetMean(const glm::dvec3& normal, double alpha, double covered);

// Share of facets, of those that face `v`, that nothing hides from it; and from both.
double unhidden(const glm::dvec3& v, double alpha);
double unhiddenFromBoth(const glm::dvec3& v, const glm::dvec3& l, double alpha);

// A facet's normal, chosen as often as `v` (v.z >= 0) sees it (Dupuy and Benyoub 2023), and that
// choice's density per steradian.
glm::dvec3 visibleFacet(const glm::dvec3& v, double alpha, const glm::dvec2& random);
double visibleFacetDensity(const glm::dvec3& v, const glm::dvec3& normal, double alpha);

// Of the direction that such a facet mirrors v to.
double mirroredDensity(const glm::dvec3& v, const glm::dvec3& l, double alpha);

// Share of uniform light that facets which reflect everything return in one bounce. From a table
// made at first use, within 2e-3.
double returnedOnce(double cosine, double alpha);

// What several bounces add to one, as a factor, for a reflectance straight on (Turquin 2019).
glm::dvec3 bouncesFactor(const glm::dvec3& f0, double cosine, double alpha);

}  // namespace clerestory::reference
