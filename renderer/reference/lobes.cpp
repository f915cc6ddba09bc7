#include "reference/lobes.h"

#include "reference/fresnel.h"
#include "reference/microfacet.h"

namespace clerestory::reference {
namespace {

// The renderer's kMinRoughness, squared.
constexpr double kMinLampAlpha = 0.045 * 0.045;

}  // namespace

glm::dvec3 cosineWeighted(const glm::dvec2& random) {
    const double radius = std::sqrt(random.x), turn = 2.0 * kPi * random.y;
    return {radius * std::cos(turn), radius * std::sin(turn), std::sqrt(1.0 - random.x)};
}

double cosineDensity(const glm::dvec3& l) {
    return std::max(l.z, 0.0) / kPi;
}

Lobes::Lobes(const Point& point, const glm::dvec3& toEye)
    : frame_(point.normal),
      v_(frame_.toLocal(toEye)),
      alpha_(point.roughness * point.roughness),
      metallic_(point.metallic),
      ior_(std::max(double(point.material->ior), 1.0)),
      f0OfIor_(reference::fresnel(1.0, ior_).mean()),
      grazing_(point.material->specular),
      metal_(glm::min(point.baseColor, 1.0)),
      diffuse_(point.baseColor * (1.0 - point.metallic)) {
    v_.z = std::max(v_.z, 1e-6);
    // KHR_materials_specular.
    dielectric_ = glm::min(f0OfIor_ * glm::dvec3(point.material->specularColor), 1.0) * grazing_;
    f0_ = glm::mix(dielectric_, metal_, metallic_);
}

bool Lobes::mirror() const {
    return alpha_ < kMinReferenceAlpha;
}

// Metals have no index in glTF: theirs is Schlick's curve by definition. Of the others, the exact
// curve's way from straight on to grazing is taken, whatever colours its ends have.
glm::dvec3 Lobes::fresnel(double cosine) const {
    const double c = std::clamp(cosine, 0.0, 1.0);
    const double exact = reference::fresnel(c, ior_).mean();
    const double way = std::clamp((exact - f0OfIor_) / (1.0 - f0OfIor_), 0.0, 1.0);
    const double x = 1.0 - c;
    return glm::mix(glm::mix(dielectric_, glm::dvec3(grazing_), way),
                    glm::mix(metal_, glm::dvec3(1.0), x * x * x * x * x), metallic_);
}

Lobes::Facet Lobes::facet(const glm::dvec2& random) const {
    const glm::dvec3 normal = mirror() ? glm::dvec3(0, 0, 1) : visibleFacet(v_, alpha_, random);
    const double cosine = glm::dot(v_, normal);
    Facet f{.towards = 2.0 * cosine * normal - v_};
    if (mirror()) {
        f.weight = fresnel(cosine);
    } else if (f.towards.z > 0.0) {
        f.weight = fresnel(cosine) * bouncesFactor(f0_, v_.z, alpha_) *
                   (unhiddenFromBoth(v_, f.towards, alpha_) / unhidden(v_, alpha_));
    }
    f.rest = 1.0 - greatest(f.weight);
    return f;
}

glm::dvec3 Lobes::lobe(const glm::dvec3& l, double alpha, double covered) const {
    const glm::dvec3 half = unitOr(v_ + l, glm::dvec3(0, 0, 1));
    return fresnel(glm::dot(v_, half)) * bouncesFactor(f0_, v_.z, alpha) *
           (facetMean(half, alpha, covered) * unhiddenFromBoth(v_, l, alpha) /
            (4.0 * v_.z * std::max(l.z, 1e-6)));
}

glm::dvec3 Lobes::specularOf(const glm::dvec3& l) const {
    return mirror() || l.z <= 0.0 ? glm::dvec3(0.0) : lobe(l, alpha_, 0.0);
}

double Lobes::densityOf(const glm::dvec3& l) const {
    return mirror() || l.z <= 0.0 ? 0.0 : mirroredDensity(v_, l, alpha_);
}

glm::dvec3 Lobes::underLamp(const glm::dvec3& l, double diffuseShare, double covered) const {
    if (l.z <= 0.0) return glm::dvec3(0.0);
    const glm::dvec3 half = unitOr(v_ + l, glm::dvec3(0, 0, 1));
    const double rest = 1.0 - greatest(fresnel(glm::dot(v_, half)));
    return lobe(l, std::max(alpha_, kMinLampAlpha), covered) +
           diffuse_ * (diffuseShare * rest / kPi);
}

}  // namespace clerestory::reference
