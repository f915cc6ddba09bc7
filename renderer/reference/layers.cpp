#include "reference/layers.h"

#include "reference/microfacets.h"
#include "reference/optics.h"

#include <array>

namespace clerestory::reference {
namespace {

// As in shaders/include/layers.glsl: the albedo exceeds 1 beyond.
constexpr double kMinSheenRoughness = 0.1, kMinSheenCosine = 0.08;

// Estevez and Kulla 2017, Production Friendly Microfacet Sheen BRDF, section 3.
double sheenLambda(double cosine, double alpha) {
    const double t = (1.0 - alpha) * (1.0 - alpha);
    const double a = std::lerp(21.5473, 25.3245, t), b = std::lerp(3.82987, 3.32435, t),
                 c = std::lerp(0.19823, 0.16801, t), d = std::lerp(-1.97760, -1.27393, t),
                 e = std::lerp(-4.32054, -4.85967, t);
    const auto fit = [&](double x) { return a / (1.0 + b * std::pow(x, c)) + d * x + e; };
    return cosine < 0.5 ? std::exp(fit(cosine)) : std::exp(2.0 * fit(0.5) - fit(1.0 - cosine));
}

// Sum of the lobe times the cosine over the hemisphere, in steps that are finer at grazing angles.
double integratedSheenAlbedo(double nDotV, double roughness) {
    constexpr int kHeights = 64, kTurns = 64;
    const double sine = std::sqrt(1.0 - nDotV * nDotV);
    double sum = 0.0;
    for (int i = 0; i < kHeights; ++i) {
        const double root = (i + 0.5) / kHeights, z = root * root, s = std::sqrt(1.0 - z * z);
        for (int j = 0; j < kTurns; ++j) {
            const double turn = kPi * (j + 0.5) / kTurns;
            const glm::dvec3 l(s * std::cos(turn), s * std::sin(turn), z);
            const glm::dvec3 half = glm::normalize(l + glm::dvec3(sine, 0.0, nDotV));
            sum += sheenLobe(z, nDotV, half.z, roughness) * z * 2.0 * root;
        }
    }
    return sum * 2.0 * kPi / (kHeights * kTurns);
}

constexpr int kSheenTable = 32;
using SheenTable = std::array<std::array<double, kSheenTable>, kSheenTable>;

const SheenTable& sheenTable() {
    static const SheenTable table = [] {
        SheenTable t{};
        for (int r = 0; r < kSheenTable; ++r) {
            for (int c = 0; c < kSheenTable; ++c) {
                const double part = double(c) / (kSheenTable - 1);
                t[r][c] = integratedSheenAlbedo(std::lerp(kMinSheenCosine, 1.0, part * part),
                                                double(r) / (kSheenTable - 1));
            }
        }
        return t;
    }();
    return table;
}

// Rows of linear Rec. 709 from CIE XYZ.
const glm::dmat3 kRgbFromXyz =
    glm::transpose(glm::dmat3(3.2404542, -1.5371385, -0.4985314, -0.9692660, 1.8760108, 0.0415560,
                              0.0556434, -0.2040259, 1.0572252));

// Colour matching functions as sums of Gaussians (Wyman, Sloan and Shirley 2013). nanometres.
glm::dvec3 colorMatching(double wavelength) {
    const auto lobe = [&](double scale, double mean, double below, double above) {
        const double t = (wavelength - mean) * (wavelength < mean ? below : above);
        return scale * std::exp(-0.5 * t * t);
    };
    return {lobe(0.362, 442.0, 0.0624, 0.0374) + lobe(1.056, 599.8, 0.0264, 0.0323) +
                lobe(-0.065, 501.1, 0.0490, 0.0382),
            lobe(0.821, 568.8, 0.0213, 0.0247) + lobe(0.286, 530.9, 0.0613, 0.0322),
            lobe(1.217, 437.0, 0.0845, 0.0278) + lobe(0.681, 459.0, 0.0385, 0.0725)};
}

struct Wavelength {
    double nanometres;
    glm::dvec3 weight;  // of each primary; the weights of all wavelengths add up to 1
};

const std::vector<Wavelength>& spectrum() {
    static const std::vector<Wavelength> table = [] {
        std::vector<Wavelength> t;
        glm::dvec3 sum(0.0);
        for (double l = 380.0; l <= 780.0; l += 5.0) {
            t.push_back({l, kRgbFromXyz * colorMatching(l)});
            sum += t.back().weight;
        }
        for (Wavelength& w : t) w.weight /= sum;
        return t;
    }();
    return table;
}

// Amplitudes of reflection at two interfaces, for one polarisation.
struct Interfaces {
    double first = 0.0, second = 0.0;
};

double airyReflectance(const Interfaces& r, double cosineOfPhase) {
    const double product = r.first * r.second, cross = 2.0 * product * cosineOfPhase;
    return (r.first * r.first + r.second * r.second + cross) / (1.0 + product * product + cross);
}

}  // namespace

double sheenLobe(double nDotL, double nDotV, double nDotH, double roughness) {
    if (nDotL <= 0.0) return 0.0;
    const double r = std::max(roughness, kMinSheenRoughness), alpha = r * r;
    const double sine2 = std::clamp(1.0 - nDotH * nDotH, 1e-6, 1.0);
    const double density = (2.0 + 1.0 / alpha) * std::pow(sine2, 0.5 / alpha) / (2.0 * kPi);
    const double v = std::clamp(nDotV, kMinSheenCosine, 1.0),
                 l = std::clamp(nDotL, kMinSheenCosine, 1.0);
    const double shadowing = 1.0 / (1.0 + sheenLambda(v, alpha) + sheenLambda(l, alpha));
    return density * shadowing / (4.0 * v * nDotL);
}

double sheenAlbedo(double nDotV, double roughness) {
    const SheenTable& table = sheenTable();
    const double part =
        (std::clamp(nDotV, kMinSheenCosine, 1.0) - kMinSheenCosine) / (1.0 - kMinSheenCosine);
    const double x = std::sqrt(part) * (kSheenTable - 1);
    const double y = std::clamp(roughness, 0.0, 1.0) * (kSheenTable - 1);
    const int column = std::min(int(x), kSheenTable - 2), row = std::min(int(y), kSheenTable - 2);
    const auto inRow = [&](int r) {
        return std::lerp(table[r][column], table[r][column + 1], x - column);
    };
    return std::lerp(inRow(row), inRow(row + 1), y - row);
}

glm::dvec3 filmReflectance(double cosine, double filmIor, double thickness, const glm::dvec3& f0) {
    const double c1 = std::clamp(cosine, 1e-4, 1.0), eta = std::max(filmIor, 1.0);
    const double c2 = refractedCosine(c1, eta);
    glm::dvec3 sum(0.0);
    for (int channel = 0; channel < 3; ++channel) {
        const double root = std::sqrt(std::clamp(f0[channel], 1e-4, 0.9999));
        const double base = (1.0 + root) / (1.0 - root);
        const double c3 =
            std::sqrt(std::max(1.0 - (eta / base) * (eta / base) * (1.0 - c2 * c2), 0.0));
        const Interfaces s{(c1 - eta * c2) / (c1 + eta * c2),
                           (eta * c2 - base * c3) / (eta * c2 + base * c3)};
        const Interfaces p{(eta * c1 - c2) / (eta * c1 + c2),
                           (base * c2 - eta * c3) / (base * c2 + eta * c3)};
        for (const Wavelength& w : spectrum()) {
            const double phase = std::cos(4.0 * kPi * eta * thickness * c2 / w.nanometres);
            sum[channel] +=
                w.weight[channel] * 0.5 * (airyReflectance(s, phase) + airyReflectance(p, phase));
        }
    }
    return glm::clamp(sum, 0.0, 1.0);
}

glm::dvec3 underFilm(const SurfaceInteraction& point, double cosine, double fresnel) {
    const SurfaceInteraction::Layers& layers = point.layers;
    const glm::dvec3 bare(fresnel);
    if (!(layers.film > 0.0)) return bare;
    const double root = (point.ior - 1.0) / (point.ior + 1.0);
    const glm::dvec3 film =
        filmReflectance(cosine, layers.filmIor, layers.filmThickness, glm::dvec3(root * root));
    return glm::mix(bare, film, layers.film);
}

}  // namespace clerestory::reference
