// The reflection of a uniform environment by one lobe, as a sum over the visible microfacets.
#include "scene/environment_brdf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace clerestory {
namespace {

// Sample points on the disc of visible normals, by ring and angle. The rings are denser near the
// rim, u = 1 - (1 - t)^3 for the squared radius u, where the long tail of GGX reflects into the
// surface. Each angle shifts its rings by the golden ratio, which samples the edge of that tail
// evenly. Errors are below 1e-3 (environment_brdf_test).
constexpr int kRings = 32;
constexpr int kTurns = 16;

struct DiscPoint {
    float across = 0.0f, along = 0.0f;
    float weight = 0.0f;  // the sum is 1
};

// Half the disc is enough by symmetry.
std::array<DiscPoint, kRings * kTurns> discPoints() {
    std::array<DiscPoint, kRings * kTurns> points{};
    std::array<double, kRings * kTurns> weights{};
    double total = 0.0;
    for (int turn = 0; turn < kTurns; ++turn) {
        const double angle = std::numbers::pi * ((turn + 0.5) / kTurns - 0.5);
        double shift = (turn + 0.5) / std::numbers::phi;
        shift -= std::floor(shift);
        for (int ring = 0; ring < kRings; ++ring) {
            const auto i = static_cast<std::size_t>(turn * kRings + ring);
            const double left = 1.0 - (ring + shift) / kRings;
            const double radius = std::sqrt(1.0 - left * left * left);
            points[i].across = static_cast<float>(radius * std::cos(angle));
            points[i].along = static_cast<float>(radius * std::sin(angle));
            weights[i] = left * left;
            total += weights[i];
        }
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
        points[i].weight = static_cast<float>(weights[i] / total);
    }
    return points;
}

}  // namespace

glm::vec2 environmentBrdf(float nDotV, float roughness) {
    const float c = std::clamp(nDotV, 0.0f, 1.0f);
    const float alpha = std::clamp(roughness, 0.0f, 1.0f) * std::clamp(roughness, 0.0f, 1.0f);
    const auto schlick = [](float cosine) {
        const float x = std::clamp(1.0f - cosine, 0.0f, 1.0f);
        const float x2 = x * x;
        return x2 * x2 * x;
    };
    // A mirror: the only microfacet normal is that of the surface.
    if (alpha < 1e-6f) return {1.0f - schlick(c), schlick(c)};

    // Visible normals (Heitz 2018): stretch the eye's direction v = (s, 0, c) so that the surface
    // becomes a hemisphere, sample its normals through the disc, and stretch back.
    const float s = std::sqrt(1.0f - c * c);
    const float stretched = 1.0f / std::sqrt(alpha * alpha * s * s + c * c);
    const float vx = alpha * s * stretched, vz = c * stretched;
    const float blend = 0.5f * (1.0f + vz);
    const float a2 = alpha * alpha;
    const float towardsEye = std::sqrt(a2 + (1.0f - a2) * c * c);
    float scale = 0.0f, bias = 0.0f;
    static const auto points = discPoints();
    for (const DiscPoint& p : points) {
        const float rim = std::sqrt(1.0f - p.across * p.across);
        const float along = (1.0f - blend) * rim + blend * p.along;
        const float out = std::sqrt(std::max(1.0f - p.across * p.across - along * along, 0.0f));
        // across * (0,1,0) + along * (-vz,0,vx) + out * v, then stretched back.
        const float hx = alpha * (out * vx - along * vz);
        const float hy = alpha * p.across;
        const float hz = std::max(along * vx + out * vz, 0.0f);
        const float inverse = 1.0f / std::sqrt(std::max(hx * hx + hy * hy + hz * hz, 1e-20f));
        const float eyeOnFacet = std::max((hx * s + hz * c) * inverse, 0.0f);
        const float l = 2.0f * eyeOnFacet * hz * inverse - c;  // n.l
        if (l <= 0.0f) continue;
        // G2 / G1 of the height-correlated Smith function: at most 1.
        const float towardsLight = std::sqrt(a2 + (1.0f - a2) * l * l);
        const float shown = l * (c + towardsEye) / (c * towardsLight + l * towardsEye);
        const float edge = schlick(eyeOnFacet);
        scale += p.weight * shown * (1.0f - edge);
        bias += p.weight * shown * edge;
    }
    return {scale, bias};
}

std::vector<glm::vec2> environmentBrdfTable(std::uint32_t size) {
    const std::uint32_t n = std::max(size, 2u);
    std::vector<glm::vec2> table;
    table.reserve(std::size_t(n) * n);
    for (std::uint32_t row = 0; row < n; ++row) {
        for (std::uint32_t column = 0; column < n; ++column) {
            const float root = float(column) / float(n - 1);
            table.push_back(environmentBrdf(root * root, float(row) / float(n - 1)));
        }
    }
    return table;
}

}  // namespace clerestory
