#include "reference/bsdf.h"

#include "reference/layers.h"
#include "reference/scene_geometry.h"

#include <array>

namespace clerestory::reference {
namespace {

// The renderer's kMinRoughness, squared.
constexpr double kMinPunctualAlpha = 0.045 * 0.045;

}  // namespace

double refractedCosine(double cosine, double eta) {
    const double c = std::clamp(cosine, 0.0, 1.0);
    // eta^2 cosine'^2 = eta^2 - sin^2
    const double squared = (eta - 1.0) * (eta + 1.0) + c * c;
    return squared < 0.0 ? -1.0 : std::min(1.0, std::sqrt(squared) / eta);
}

PolarisedReflectance fresnel(double cosine, double eta) {
    if (std::abs(eta - 1.0) < 1e-9) return {0.0, 0.0};
    const double in = std::clamp(cosine, 0.0, 1.0);
    const double out = refractedCosine(in, eta);
    if (out < 0.0) return {1.0, 1.0};
    // The divisors are 0 only at the critical angle and grazing, where reflection is total.
    const double sDivisor = in + eta * out, pDivisor = eta * in + out;
    if (!(sDivisor > 0.0) || !(pDivisor > 0.0)) return {1.0, 1.0};
    const double s = (in - eta * out) / sDivisor, p = (eta * in - out) / pDivisor;
    return {s * s, p * p};
}

glm::dvec3 refracted(const glm::dvec3& incident, const glm::dvec3& normal, double eta) {
    const double c = -glm::dot(incident, normal);
    const double out = std::max(refractedCosine(c, eta), 0.0);
    return unitOr((incident + normal * c) / eta - normal * out, incident);
}

PaneCoefficients paneCoefficients(double cosine, double ior, const glm::dvec3& transmittance) {
    const PolarisedReflectance f = fresnel(cosine, ior);
    PaneCoefficients sum;
    for (const double r : {f.s, f.p}) {
        for (int i = 0; i < 3; ++i) {
            const double a = std::clamp(transmittance[i], 0.0, 1.0);
            const double divisor = 1.0 - r * r * a * a;
            const double t = divisor > 1e-12 ? (1.0 - r) * (1.0 - r) * a / divisor : 0.0;
            sum.transmitted[i] += 0.5 * t;
            sum.reflected[i] += 0.5 * r * (1.0 + a * t);
        }
    }
    return sum;
}

glm::dvec3 beerLambert(const glm::dvec3& color, double attenuationDistance, double distance) {
    if (!(attenuationDistance > 0.0) || !(distance > 0.0)) return glm::dvec3(1.0);
    const double ratio = distance / attenuationDistance;
    return glm::pow(glm::clamp(color, 0.0, 1.0), glm::dvec3(ratio));
}

namespace {

// Smith's Lambda: hidden microfacets per visible one.
double smithLambda(const glm::dvec3& v, const glm::dvec2& alpha) {
    const double z2 = v.z * v.z;
    if (z2 <= 0.0) return 1e9;
    const glm::dvec2 stretched = alpha * glm::dvec2(v);
    return 0.5 * (std::sqrt(1.0 + glm::dot(stretched, stretched) / z2) - 1.0);
}

}  // namespace

double normalDistribution(const glm::dvec3& normal, const glm::dvec2& alpha) {
    if (normal.z <= 0.0) return 0.0;
    const double x = normal.x * alpha.y, y = normal.y * alpha.x, product = alpha.x * alpha.y;
    const double k = x * x + y * y + product * product * normal.z * normal.z;
    return product * product * product / (kPi * k * k);
}

double meanNormalDistribution(const glm::dvec3& normal, double alpha, double discRadius2) {
    if (normal.z <= 0.0) return 0.0;
    if (discRadius2 < 1e-9 * alpha * alpha) return normalDistribution(normal, alpha);
    const double z2 = normal.z * normal.z, a2 = alpha * alpha;
    const double slope2 = (normal.x * normal.x + normal.y * normal.y) / z2;
    // (1 - a / s) / (2 discRadius2); the other form avoids cancellation for distant discs.
    const double a = a2 + slope2 - discRadius2, s = std::sqrt(a * a + 4.0 * a2 * discRadius2);
    const double mean = a > 0.0 ? 2.0 * a2 / (s * (s + a)) : (s - a) / (2.0 * discRadius2 * s);
    return mean / (kPi * z2 * z2);
}

double masking(const glm::dvec3& v, const glm::dvec2& alpha) {
    return 1.0 / (1.0 + smithLambda(v, alpha));
}

double maskingShadowing(const glm::dvec3& v, const glm::dvec3& l, const glm::dvec2& alpha) {
    return 1.0 / (1.0 + smithLambda(v, alpha) + smithLambda(l, alpha));
}

glm::dvec3 sampleVisibleNormal(const glm::dvec3& v, const glm::dvec2& alpha, const glm::dvec2& u) {
    // In stretched space the microfacets form a hemisphere, whose reflections of v fill a spherical
    // cap.
    const glm::dvec3 stretched =
        unitOr({alpha.x * v.x, alpha.y * v.y, std::max(v.z, 0.0)}, glm::dvec3(0, 0, 1));
    const double phi = 2.0 * kPi * u.x;
    const double z = (1.0 - u.y) * (1.0 + stretched.z) - stretched.z;
    const double radius = std::sqrt(std::clamp(1.0 - z * z, 0.0, 1.0));
    const glm::dvec3 half =
        glm::dvec3(radius * std::cos(phi), radius * std::sin(phi), z) + stretched;
    return unitOr({alpha.x * half.x, alpha.y * half.y, std::max(half.z, 0.0)}, glm::dvec3(0, 0, 1));
}

double visibleNormalPdf(const glm::dvec3& v, const glm::dvec3& normal, const glm::dvec2& alpha) {
    const double z = std::max(v.z, 1e-9);
    return masking(v, alpha) * std::max(glm::dot(v, normal), 0.0) *
           normalDistribution(normal, alpha) / z;
}

double reflectionPdf(const glm::dvec3& v, const glm::dvec3& l, const glm::dvec2& alpha) {
    const glm::dvec3 half = unitOr(v + l, glm::dvec3(0, 0, 1));
    const double cosine = glm::dot(v, half);
    return cosine > 0.0 ? visibleNormalPdf(v, half, alpha) / (4.0 * cosine) : 0.0;
}

namespace {

constexpr int kTableSize = 48;  // uniform in sqrt(cosine) and in sqrt(alpha)
constexpr int kTableSamples = 32 * 32;

double integrateSingleScatterAlbedo(double cosine, double alpha) {
    if (alpha < kMinReferenceAlpha) return 1.0;
    const double c = std::max(cosine, 1e-4);
    const glm::dvec3 v(std::sqrt(1.0 - c * c), 0.0, c);
    double sum = 0.0;
    for (int i = 0; i < kTableSamples; ++i) {
        const glm::dvec2 u((i % 32 + 0.5) / 32, (i / 32 + 0.5) / 32);
        const glm::dvec3 facet = sampleVisibleNormal(v, alpha, u);
        const glm::dvec3 l = 2.0 * glm::dot(v, facet) * facet - v;
        if (l.z > 0.0) sum += maskingShadowing(v, l, alpha) / masking(v, alpha);
    }
    return sum / kTableSamples;
}

using Table = std::array<std::array<double, kTableSize>, kTableSize>;

const Table& singleScatterAlbedoTable() {
    static const Table table = [] {
        Table t{};
        for (int row = 0; row < kTableSize; ++row) {
            const double roughness = double(row) / (kTableSize - 1);
            for (int column = 0; column < kTableSize; ++column) {
                const double root = double(column) / (kTableSize - 1);
                t[row][column] = integrateSingleScatterAlbedo(root * root, roughness * roughness);
            }
        }
        return t;
    }();
    return table;
}

}  // namespace

double singleScatterAlbedo(double cosine, double alpha) {
    const Table& table = singleScatterAlbedoTable();
    const double x = std::sqrt(std::clamp(cosine, 0.0, 1.0)) * (kTableSize - 1);
    const double y = std::sqrt(std::clamp(alpha, 0.0, 1.0)) * (kTableSize - 1);
    const int column = std::min(int(x), kTableSize - 2), row = std::min(int(y), kTableSize - 2);
    const auto inRow = [&](int r) {
        return std::lerp(table[r][column], table[r][column + 1], x - column);
    };
    return std::lerp(inRow(row), inRow(row + 1), y - row);
}

glm::dvec3 multipleScatterFactor(const glm::dvec3& f0, double cosine, double alpha) {
    return 1.0 + f0 * (1.0 / std::max(singleScatterAlbedo(cosine, alpha), 0.05) - 1.0);
}

glm::dvec3 sampleCosineHemisphere(const glm::dvec2& u) {
    const double radius = std::sqrt(u.x), phi = 2.0 * kPi * u.y;
    return {radius * std::cos(phi), radius * std::sin(phi), std::sqrt(1.0 - u.x)};
}

double cosineHemispherePdf(const glm::dvec3& l) {
    return std::max(l.z, 0.0) / kPi;
}

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
    const glm::dvec3 half = unitOr(v_ + l, glm::dvec3(0, 0, 1));
    const double diffuseFactor = 1.0 - greatest(dielectricFresnel(glm::dot(v_, half)));
    return microfacetLobe(l, std::max(alpha_, kMinPunctualAlpha), discRadius2) +
           diffuse_ * (diffuseScale * diffuseFactor / kPi);
}

}  // namespace clerestory::reference
