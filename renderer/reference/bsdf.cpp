#include "reference/bsdf.h"

#include "reference/layers.h"

namespace clerestory::reference {
namespace {

double leastCosineOver(const glm::dvec3& face, const glm::dvec3& toEye) {
    return std::sin(0.5 * std::asin(std::clamp(std::abs(glm::dot(face, toEye)), 0.0, 1.0)));
}

}  // namespace

Bsdf::Bsdf(const SurfaceInteraction& point, const glm::dvec3& toEye)
    : frame_(point.layers.anisotropy > 0.0 ? Frame(point.normal, point.layers.grain)
                                           : Frame(point.normal)),
      v_(frame_.toLocal(toEye)),
      leastCosine_(leastCosineOver(point.geometricNormal, toEye)),
      alpha_(point.roughness * point.roughness),
      metallic_(point.metallic),
      ior_(std::max(point.ior, 1.0)),
      f0OfIor_(reference::fresnel(1.0, ior_).mean()),
      f90_(point.specular),
      metal_(glm::min(point.baseColor, 1.0)),
      diffuse_(point.baseColor * (1.0 - point.metallic) * (1.0 - point.layers.throughShare)) {
    const double grain = point.layers.anisotropy;
    alphas_ = {std::lerp(alpha_, 1.0, grain * grain), alpha_};
    scatteringAlpha_ = 0.5 * (alphas_.x + alphas_.y);
    film_ = point.layers.film;
    filmIor_ = point.layers.filmIor;
    filmThickness_ = point.layers.filmThickness;
    if (point.lobe == SurfaceInteraction::Lobe::sheen) {
        isSheen_ = true;
        sheenRoughness_ = point.roughness;
        alpha_ = 1.0;
        metal_ = point.baseColor;
        diffuse_ = glm::dvec3(0.0);
    }
    v_.z = std::max(v_.z, 1e-6);
    // KHR_materials_specular.
    dielectric_ = glm::min(f0OfIor_ * point.specularColor, 1.0) * f90_;
}

double Bsdf::clampedCosine(double cosine) const {
    return std::clamp(cosine, leastCosine_, 1.0);
}

bool Bsdf::isMirror() const {
    return alpha_ < kMinReferenceAlpha;
}

// glTF defines metals by Schlick's approximation. For dielectrics, the exact curve interpolates
// between the colours at normal incidence and at grazing.
glm::dvec3 Bsdf::fresnel(double cosine) const {
    return glm::mix(dielectricFresnel(cosine), metalFresnel(cosine), metallic_);
}

// Several bounces between microfacets are not linear in the reflectance: each of the two materials
// has its own.
glm::dvec3 Bsdf::scatteredFresnel(double cosine, double alpha) const {
    const double mean = std::max(alpha, scatteringAlpha_);
    return glm::mix(dielectricFresnel(cosine) * multipleScatterFactor(dielectric_, v_.z, mean),
                    metalFresnel(cosine) * multipleScatterFactor(metal_, v_.z, mean), metallic_);
}

glm::dvec3 Bsdf::metalFresnel(double cosine) const {
    const double x = 1.0 - clampedCosine(cosine);
    return underFilm(glm::mix(metal_, glm::dvec3(1.0), x * x * x * x * x), metal_, cosine);
}

glm::dvec3 Bsdf::dielectricFresnel(double cosine) const {
    const double exact = reference::fresnel(clampedCosine(cosine), ior_).mean();
    const double curve = std::clamp((exact - f0OfIor_) / (1.0 - f0OfIor_), 0.0, 1.0);
    return underFilm(glm::mix(dielectric_, glm::dvec3(f90_), curve), dielectric_, cosine);
}

glm::dvec3 Bsdf::underFilm(const glm::dvec3& base, const glm::dvec3& f0, double cosine) const {
    if (!(film_ > 0.0)) return base;
    return glm::mix(base, filmReflectance(clampedCosine(cosine), filmIor_, filmThickness_, f0),
                    film_);
}

glm::dvec3 Bsdf::sheenLobe(const glm::dvec3& l) const {
    const glm::dvec3 half = unitOr(v_ + l, glm::dvec3(0, 0, 1));
    return metal_ * reference::sheenLobe(l.z, v_.z, half.z, sheenRoughness_);
}

Bsdf::SpecularSample Bsdf::sampleSpecular(const glm::dvec2& u) const {
    if (isSheen_) {
        const glm::dvec3 l = sampleCosineHemisphere(u);
        return {.direction = l, .weight = sheenLobe(l) * kPi};
    }
    const glm::dvec3 normal =
        isMirror() ? glm::dvec3(0, 0, 1) : sampleVisibleNormal(v_, alphas_, u);
    const double cosine = glm::dot(v_, normal);
    SpecularSample f{.direction = 2.0 * cosine * normal - v_};
    // glTF mixes a metal with a dielectric, whose lobe alone takes light from the diffuse one.
    glm::dvec3 dielectric(0.0);
    if (isMirror()) {
        f.weight = fresnel(cosine);
        dielectric = dielectricFresnel(cosine);
    } else if (f.direction.z > 0.0) {
        const double visible = maskingShadowing(v_, f.direction, alphas_) / masking(v_, alphas_);
        f.weight = scatteredFresnel(cosine, alpha_) * visible;
        dielectric = dielectricFresnel(cosine) *
                     multipleScatterFactor(dielectric_, v_.z, scatteringAlpha_) * visible;
    }
    f.diffuseFactor = 1.0 - greatest(dielectric);
    return f;
}

glm::dvec3 Bsdf::microfacetLobe(const glm::dvec3& l, double alpha, double discRadius2) const {
    const glm::dvec3 half = unitOr(v_ + l, glm::dvec3(0, 0, 1));
    const glm::dvec2 alphas(std::max(alphas_.x, alpha), alpha);
    // The footprint of a lobe with a grain is not averaged.
    const double density = alphas.x > alphas.y ? normalDistribution(half, alphas)
                                               : meanNormalDistribution(half, alpha, discRadius2);
    return scatteredFresnel(glm::dot(v_, half), alpha) *
           (density * maskingShadowing(v_, l, alphas) / (4.0 * v_.z * std::max(l.z, 1e-6)));
}

glm::dvec3 Bsdf::evalSpecular(const glm::dvec3& l) const {
    if (isMirror() || l.z <= 0.0) return glm::dvec3(0.0);
    return isSheen_ ? sheenLobe(l) : microfacetLobe(l, alpha_, 0.0);
}

double Bsdf::specularPdf(const glm::dvec3& l) const {
    if (isMirror() || l.z <= 0.0) return 0.0;
    return isSheen_ ? cosineHemispherePdf(l) : reflectionPdf(v_, l, alphas_);
}

glm::dvec3 Bsdf::evalPunctual(const glm::dvec3& l, double diffuseScale, double discRadius2) const {
    if (l.z <= 0.0) return glm::dvec3(0.0);
    if (isSheen_) return sheenLobe(l);
    return microfacetLobe(l, std::max(alpha_, kMinPunctualAlpha), discRadius2) +
           diffuseScale * evalDiffuse(l);
}

glm::dvec3 Bsdf::evalDiffuse(const glm::dvec3& l) const {
    if (l.z <= 0.0) return glm::dvec3(0.0);
    const glm::dvec3 half = unitOr(v_ + l, glm::dvec3(0, 0, 1));
    const double diffuseFactor = 1.0 - greatest(dielectricFresnel(glm::dot(v_, half)));
    return diffuse_ * (diffuseFactor / kPi);
}

}  // namespace clerestory::reference
