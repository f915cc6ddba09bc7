// FLIP (Andersson et al. 2020). Constants and names are those of the paper, with its section
// numbers. Images are extended by their border pixels.
#include "measures/errors.h"
#include "measures/measured_pixels.h"

#include <glm/glm.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace clerestory {
namespace {

constexpr double kColourPower = 0.7;       // q_c
constexpr double kColourKnee = 0.4;        // p_c, relative to the maximum distance
constexpr double kColourAtKnee = 0.95;     // p_t
constexpr double kFeaturePower = 0.5;      // q_f
constexpr double kFeatureDegrees = 0.082;  // w: width of detected features

// Linear sRGB to XYZ with white at D65, IEC 61966-2-1; columns.
const glm::dmat3 kXyzFromRgb{0.4124564, 0.2126729, 0.0193339, 0.3575761, 0.7151522,
                             0.1191920, 0.1804375, 0.0721750, 0.9503041};
const glm::dmat3 kRgbFromXyz = glm::inverse(kXyzFromRgb);
const glm::dvec3 kWhite = kXyzFromRgb * glm::dvec3(1.0);

double linearOf(double code) {
    const double x = std::clamp(code, 0.0, 1.0);
    return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
}

// YCxCz: CIELAB with linear functions in place of cube roots.
glm::dvec3 opponentOf(glm::dvec3 linear) {
    const glm::dvec3 xyz = kXyzFromRgb * linear / kWhite;
    return {116.0 * xyz.y - 16.0, 500.0 * (xyz.x - xyz.y), 200.0 * (xyz.y - xyz.z)};
}
glm::dvec3 linearOfOpponent(glm::dvec3 opponent) {
    const double y = (opponent.x + 16.0) / 116.0;
    const glm::dvec3 xyz{y + opponent.y / 500.0, y, y - opponent.z / 200.0};
    return kRgbFromXyz * (xyz * kWhite);
}

// CIELAB with chroma scaled by lightness (Hunt effect).
glm::dvec3 huntLabOf(glm::dvec3 linear) {
    const auto root = [](double t) {
        constexpr double kLimit = 6.0 / 29.0;
        return t > kLimit * kLimit * kLimit ? std::cbrt(t)
                                            : t / (3.0 * kLimit * kLimit) + 4.0 / 29.0;
    };
    const glm::dvec3 xyz = kXyzFromRgb * linear / kWhite;
    const double x = root(xyz.x), y = root(xyz.y), z = root(xyz.z);
    const double lightness = 116.0 * y - 16.0, weight = 0.01 * lightness;
    return {lightness, weight * 500.0 * (x - y), weight * 200.0 * (y - z)};
}

double hyab(glm::dvec3 a, glm::dvec3 b) {
    const glm::dvec3 d = a - b;
    return std::abs(d.x) + std::hypot(d.y, d.z);
}

// ---- colour: contrast sensitivity, then colour distance (sections 4.1.1 to 4.1.3) -------------

// Contrast sensitivity as one or two Gaussians over an angle in degrees:
// a sqrt(pi / b) exp(-pi^2 x^2 / b).
struct Gaussian {
    double a, b;
};
double sigmaOf(Gaussian g, double pixelsPerDegree) {  // pixels
    return std::sqrt(g.b / 2.0) / std::numbers::pi * pixelsPerDegree;
}

Layer resolved(const Layer& layer, std::span<const Gaussian> gaussians, double pixelsPerDegree) {
    constexpr double kWidest = 0.04;  // b of the widest Gaussian, whose radius all use
    const int radius = static_cast<int>(std::ceil(3.0 * sigmaOf({1.0, kWidest}, pixelsPerDegree)));
    Layer sum{layer.width, layer.height, std::vector<double>(layer.values.size())};
    double weights = 0.0;
    for (const Gaussian g : gaussians) {
        const double sigma = sigmaOf(g, pixelsPerDegree);
        double line = 0.0;  // the sum over a square is the square of the sum over a line
        for (int x = -radius; x <= radius; ++x) line += std::exp(-0.5 * x * x / (sigma * sigma));
        const double weight = g.a * std::sqrt(std::numbers::pi / g.b) * line * line;
        const std::vector<double> window = gaussian(sigma, radius);
        const Layer part = filtered(layer, window, window);
        for (std::size_t i = 0; i < sum.values.size(); ++i) {
            sum.values[i] += weight * part.values[i];
        }
        weights += weight;
    }
    for (double& value : sum.values) value /= weights;
    return sum;
}

// Linear RGB after contrast sensitivity, within the display's range.
Layers perceived(const Layers& opponent, double pixelsPerDegree) {
    static constexpr Gaussian kAchromatic[] = {{1.0, 0.0047}};
    static constexpr Gaussian kRedGreen[] = {{1.0, 0.0053}};
    static constexpr Gaussian kBlueYellow[] = {{34.1, 0.04}, {13.5, 0.025}};
    Layers result{resolved(opponent[0], kAchromatic, pixelsPerDegree),
                  resolved(opponent[1], kRedGreen, pixelsPerDegree),
                  resolved(opponent[2], kBlueYellow, pixelsPerDegree)};
    for (std::size_t i = 0; i < result[0].values.size(); ++i) {
        const glm::dvec3 linear = glm::clamp(
            linearOfOpponent({result[0].values[i], result[1].values[i], result[2].values[i]}), 0.0,
            1.0);
        for (int c = 0; c < 3; ++c) result[std::size_t(c)].values[i] = linear[c];
    }
    return result;
}

// 0..1; small differences use most of the range.
double colourDifference(glm::dvec3 a, glm::dvec3 b) {
    static const double greatest =
        std::pow(hyab(huntLabOf({0.0, 1.0, 0.0}), huntLabOf({0.0, 0.0, 1.0})), kColourPower);
    const double distance = std::pow(hyab(huntLabOf(a), huntLabOf(b)), kColourPower);
    const double knee = kColourKnee * greatest;
    if (distance < knee) return kColourAtKnee * distance / knee;
    return std::min(kColourAtKnee + (distance - knee) / (greatest - knee) * (1.0 - kColourAtKnee),
                    1.0);
}

// ---- features: edges and points of one image only (section 4.2) -------------------------------

struct FeatureLayers {
    Layer edges, points;  // magnitudes
};

Layer magnitude(const Layer& x, const Layer& y) {
    Layer result = x;
    for (std::size_t i = 0; i < result.values.size(); ++i) {
        result.values[i] = std::hypot(x.values[i], y.values[i]);
    }
    return result;
}

FeatureLayers featuresOf(const Layer& achromatic, double pixelsPerDegree) {
    const double sigma = 0.5 * kFeatureDegrees * pixelsPerDegree;  // pixels
    const int radius = static_cast<int>(std::ceil(3.0 * sigma));
    const std::vector<double> weights = gaussian(sigma, radius);
    std::vector<double> first, second;  // derivatives of the Gaussian
    for (int x = -radius; x <= radius; ++x) {
        const double value = weights[std::size_t(x + radius)];
        first.push_back(-x * value);
        second.push_back((x * x / (sigma * sigma) - 1.0) * value);
    }
    // Normalises the sum of positive weights to 1 and that of negative weights to -1.
    for (std::vector<double>* kernel : {&first, &second}) {
        double positive = 0.0, negative = 0.0;
        for (const double weight : *kernel)
            (weight > 0.0 ? positive : negative) += std::abs(weight);
        for (double& weight : *kernel)
            weight /= std::max(weight > 0.0 ? positive : negative, 1e-30);
    }
    return {
        magnitude(filtered(achromatic, first, weights), filtered(achromatic, weights, first)),
        magnitude(filtered(achromatic, second, weights), filtered(achromatic, weights, second))};
}

Layers opponentLayers(const Layers& codes) {
    Layers result = codes;
    for (std::size_t i = 0; i < codes[0].values.size(); ++i) {
        const glm::dvec3 opponent =
            opponentOf({linearOf(codes[0].values[i]), linearOf(codes[1].values[i]),
                        linearOf(codes[2].values[i])});
        for (int c = 0; c < 3; ++c) result[std::size_t(c)].values[i] = opponent[c];
    }
    return result;
}

Layer achromaticOf(const Layers& opponent) {
    Layer result = opponent[0];
    for (double& value : result.values) value = (value + 16.0) / 116.0;  // 0..1
    return result;
}

glm::dvec3 pixelOf(const Layers& layers, std::size_t i) {
    return {layers[0].values[i], layers[1].values[i], layers[2].values[i]};
}

}  // namespace

Image flipMap(const Image& actual, const Image& reference, double pixelsPerDegree) {
    const double resolution = std::clamp(pixelsPerDegree, 1.0, 1000.0);
    const ComparedPair pair = comparedPair(actual, reference, nullptr);
    const Layers opponentA = opponentLayers(pair.actual),
                 opponentR = opponentLayers(pair.reference);
    const Layers perceivedA = perceived(opponentA, resolution),
                 perceivedR = perceived(opponentR, resolution);
    const FeatureLayers a = featuresOf(achromaticOf(opponentA), resolution);
    const FeatureLayers r = featuresOf(achromaticOf(opponentR), resolution);

    Image map = makeImage(actual.width, actual.height, 1, PixelType::float32);
    for (std::size_t i = 0; i < pair.counted.size(); ++i) {
        const double colour = colourDifference(pixelOf(perceivedA, i), pixelOf(perceivedR, i));
        const double feature = std::max(std::abs(a.edges.values[i] - r.edges.values[i]),
                                        std::abs(a.points.values[i] - r.points.values[i])) /
                               std::numbers::sqrt2;
        const double strength = std::min(std::pow(feature, kFeaturePower), 1.0);
        map.floats()[i] = static_cast<float>(std::pow(colour, 1.0 - strength));  // section 4.3
    }
    return map;
}

}  // namespace clerestory
