#include "reference/microfacets.h"

#include "reference/vectors.h"

#include <array>

namespace clerestory::reference {
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

glm::dvec3 refractingNormal(const glm::dvec3& v, const glm::dvec3& l, double eta) {
    const glm::dvec3 half = unitOr(v + eta * l, glm::dvec3(0, 0, 1));
    return half.z < 0.0 ? -half : half;
}

double refractionPdf(const glm::dvec3& v, const glm::dvec3& l, double alpha, double eta) {
    const glm::dvec3 half = refractingNormal(v, l, eta);
    const double vDotH = glm::dot(v, half), lDotH = glm::dot(l, half);
    if (!(vDotH > 0.0) || !(lDotH < 0.0)) return 0.0;
    const double both = vDotH + eta * lDotH;
    return visibleNormalPdf(v, half, alpha) * eta * eta * -lDotH / std::max(both * both, 1e-12);
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

}  // namespace clerestory::reference
