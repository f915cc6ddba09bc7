#include "reference/bsdf.h"

#include "reference/scattering.h"

namespace clerestory::reference {
namespace {

// The renderer's kMinRoughness, squared.
constexpr double kMinPunctualAlpha = 0.045 * 0.045;

}  // namespace

glm::dvec3 sampleCosineHemisphere(const glm::dvec2& u) {
    const double radius = std::sqrt(u.x), phi = 2.0 * kPi * u.y;
    return {radius * std::cos(phi), radius * std::sin(phi), std::sqrt(1.0 - u.x)};
}

double cosineHemispherePdf(const glm::dvec3& l) {
    return std::max(l.z, 0.0) / kPi;
}

Bsdf::Bsdf(const SurfaceInteraction& point, const glm::dvec3& toEye)
    : frame_(point.normal),
      v_(frame_.toLocal(toEye)),
      alpha_(point.roughness * point.roughness),
      metallic_(point.metallic),
      ior_(std::max(double(point.material->ior), 1.0)),
      f0OfIor_(reference::fresnel(1.0, ior_).mean()),
      f90_(point.material->specular),
      metal_(glm::min(point.baseColor, 1.0)),
      diffuse_(point.baseColor * (1.0 - point.metallic)) {
    v_.z = std::max(v_.z, 1e-6);
    // KHR_materials_specular.
    dielectric_ = glm::min(f0OfIor_ * glm::dvec3(point.material->specularColor), 1.0) * f90_;
    f0_ = glm::mix(dielectric_, metal_, metallic_);
}

bool Bsdf::isMirror() const {
    return alpha_ < kMinReferenceAlpha;
}

// glTF defines metals by Schlick's approximation. For dielectrics, the exact curve interpolates
// between the colours at normal incidence and at grazing.
glm::dvec3 Bsdf::fresnel(double cosine) const {
    const double c = std::clamp(cosine, 0.0, 1.0);
    const double exact = reference::fresnel(c, ior_).mean();
    const double curve = std::clamp((exact - f0OfIor_) / (1.0 - f0OfIor_), 0.0, 1.0);
    const double x = 1.0 - c;
    return glm::mix(glm::mix(dielectric_, glm::dvec3(f90_), curve),
                    glm::mix(metal_, glm::dvec3(1.0), x * x * x * x * x), metallic_);
}

Bsdf::SpecularSample Bsdf::sampleSpecular(const glm::dvec2& u) const {
    const glm::dvec3 normal = isMirror() ? glm::dvec3(0, 0, 1) : sampleVisibleNormal(v_, alpha_, u);
    const double cosine = glm::dot(v_, normal);
    SpecularSample f{.direction = 2.0 * cosine * normal - v_};
    if (isMirror()) {
        f.weight = fresnel(cosine);
    } else if (f.direction.z > 0.0) {
        f.weight = fresnel(cosine) * multipleScatterFactor(f0_, v_.z, alpha_) *
                   (maskingShadowing(v_, f.direction, alpha_) / masking(v_, alpha_));
    }
    f.diffuseFactor = 1.0 - greatest(f.weight);
    return f;
}

glm::dvec3 Bsdf::microfacetLobe(const glm::dvec3& l, double alpha, double discRadius2) const {
    const glm::dvec3 half = unitOr(v_ + l, glm::dvec3(0, 0, 1));
    return fresnel(glm::dot(v_, half)) * multipleScatterFactor(f0_, v_.z, alpha) *
           (meanNormalDistribution(half, alpha, discRadius2) * maskingShadowing(v_, l, alpha) /
            (4.0 * v_.z * std::max(l.z, 1e-6)));
}

glm::dvec3 Bsdf::evalSpecular(const glm::dvec3& l) const {
    return isMirror() || l.z <= 0.0 ? glm::dvec3(0.0) : microfacetLobe(l, alpha_, 0.0);
}

double Bsdf::specularPdf(const glm::dvec3& l) const {
    return isMirror() || l.z <= 0.0 ? 0.0 : reflectionPdf(v_, l, alpha_);
}

glm::dvec3 Bsdf::evalPunctual(const glm::dvec3& l, double diffuseScale, double discRadius2) const {
    if (l.z <= 0.0) return glm::dvec3(0.0);
    const glm::dvec3 half = unitOr(v_ + l, glm::dvec3(0, 0, 1));
    const double diffuseFactor = 1.0 - greatest(fresnel(glm::dot(v_, half)));
    return microfacetLobe(l, std::max(alpha_, kMinPunctualAlpha), discRadius2) +
           diffuse_ * (diffuseScale * diffuseFactor / kPi);
}

}  // namespace clerestory::reference
