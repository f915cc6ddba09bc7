// Cube map geometry: texel directions, solid angles, spherical harmonics, resampling of images.
#include "scene/environment.h"

#include "scene/hash.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace clerestory {
namespace {

constexpr float kTurn = 2.0f * std::numbers::pi_v<float>;
constexpr float kMaxTexel = 65504.0f;
constexpr std::uint32_t kMaxFaceSize = 1024;

// NaN, infinities and negative values become 0: comparisons with NaN are false.
float clampedRadiance(float x) {
    return x > 0.0f ? (std::isinf(x) ? 0.0f : std::min(x, kMaxTexel)) : 0.0f;
}

// An equirectangular image: x is the azimuth, y runs from +Y to -Y.
struct Panorama {
    std::uint32_t width = 0, height = 0;
    std::vector<glm::vec3> texels;

    const glm::vec3& at(std::uint32_t x, std::uint32_t y) const {
        return texels[std::size_t(y) * width + x];
    }
};

Panorama halved(const Panorama& from) {
    Panorama to{.width = from.width / 2, .height = from.height / 2};
    to.texels.reserve(std::size_t(to.width) * to.height);
    for (std::uint32_t y = 0; y < to.height; ++y) {
        for (std::uint32_t x = 0; x < to.width; ++x) {
            to.texels.push_back(0.25f *
                                (from.at(2 * x, 2 * y) + from.at(2 * x + 1, 2 * y) +
                                 from.at(2 * x, 2 * y + 1) + from.at(2 * x + 1, 2 * y + 1)));
        }
    }
    return to;
}

// In turns: about the vertical from +Z, and half of the way from +Y to -Y.
float azimuth(const glm::vec3& direction) {
    return 0.5f + std::atan2(direction.x, -direction.z) / kTurn;
}
float fall(const glm::vec3& direction) {
    const float length = glm::length(direction);  // at least 1, see cubeTexelDirection
    return std::acos(std::clamp(direction.y / length, -1.0f, 1.0f)) * 2.0f / kTurn;
}

// Bilinear; repeats in x, clamps at the poles.
glm::vec3 lookUp(const Panorama& map, float azimuth, float fall) {
    const float x = azimuth * float(map.width) - 0.5f;
    const float y = std::clamp(fall * float(map.height) - 0.5f, 0.0f, float(map.height - 1));
    const float left = std::floor(x), top = std::floor(y);
    const auto column = [&](float c) {
        return (static_cast<std::uint32_t>(c + float(map.width))) % map.width;
    };
    const std::uint32_t x0 = column(left), x1 = column(left + 1.0f);
    const auto y0 = static_cast<std::uint32_t>(top);
    const std::uint32_t y1 = std::min(y0 + 1, map.height - 1);
    return glm::mix(glm::mix(map.at(x0, y0), map.at(x1, y0), x - left),
                    glm::mix(map.at(x0, y1), map.at(x1, y1), x - left), y - top);
}

// Texels in the middle of a face are the largest: 2 / faceSize. None is larger than one of the
// panorama, 2 pi / width.
std::uint32_t faceSizeFor(std::uint32_t width) {
    std::uint32_t size = 4;
    while (size < kMaxFaceSize &&
           static_cast<float>(size) * std::numbers::pi_v<float> < static_cast<float>(width)) {
        size *= 2;
    }
    return size;
}

// OpenGL's table of faces; s and t in -1..1 from the texture's left and first row.
glm::vec3 cubeDirection(std::uint32_t face, float s, float t) {
    switch (face) {
        case 0:
            return {1.0f, -t, -s};
        case 1:
            return {-1.0f, -t, s};
        case 2:
            return {s, 1.0f, t};
        case 3:
            return {s, -1.0f, -t};
        case 4:
            return {s, -t, 1.0f};
        default:
            return {-s, -t, -1.0f};
    }
}

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

glm::vec3 cubeTexelDirection(std::uint32_t face, std::uint32_t x, std::uint32_t y,
                             std::uint32_t faceSize) {
    const float scale = 2.0f / float(faceSize);
    return cubeDirection(face, (float(x) + 0.5f) * scale - 1.0f, (float(y) + 0.5f) * scale - 1.0f);
}

EnvironmentMap environmentFromEquirectangular(std::string name,
                                              const std::vector<glm::vec3>& texels,
                                              std::uint32_t width, std::uint32_t height) {
    if (width == 0 || height == 0 || texels.size() != std::size_t(width) * height) {
        throw std::runtime_error("environment " + name + ": the image is empty or incomplete");
    }
    Panorama panorama{.width = width, .height = height, .texels = texels};
    for (glm::vec3& texel : panorama.texels) {
        texel = {clampedRadiance(texel.x), clampedRadiance(texel.y), clampedRadiance(texel.z)};
    }
    EnvironmentMap map{.name = name, .title = name};
    map.faceSize = faceSizeFor(width);
    while (panorama.width >= 8 * map.faceSize && panorama.height >= 2) panorama = halved(panorama);

    // Four bilinear samples a texel keep the flux of lights as small as a texel of the panorama.
    // On the four faces about the vertical, rows of samples differ in their fall alone, columns in
    // their azimuth.
    const std::uint32_t samples = 2 * map.faceSize;
    const auto direction = [&](std::uint32_t face, std::uint32_t x, std::uint32_t y) {
        return cubeTexelDirection(face, x, y, samples);
    };
    std::vector<float> falls(std::size_t{samples} * samples), azimuths(samples);
    for (std::uint32_t y = 0, i = 0; y < samples; ++y) {
        for (std::uint32_t x = 0; x < samples; ++x, ++i) falls[i] = fall(direction(0, x, y));
    }
    map.texels.resize(6 * std::size_t(map.faceSize) * map.faceSize);
    for (std::uint32_t face = 0; face < 6; ++face) {
        const bool aside = face != 2 && face != 3;
        for (std::uint32_t x = 0; x < samples; ++x) azimuths[x] = azimuth(direction(face, x, 0));
        glm::vec3* faceTexels = &map.texels[std::size_t{face} * map.faceSize * map.faceSize];
        for (std::uint32_t y = 0, i = 0; y < samples; ++y) {
            for (std::uint32_t x = 0; x < samples; ++x, ++i) {
                const glm::vec3 d = aside ? glm::vec3(0.0f) : direction(face, x, y);
                faceTexels[y / 2 * map.faceSize + x / 2] +=
                    0.25f *
                    lookUp(panorama, aside ? azimuths[x] : azimuth(d), aside ? falls[i] : fall(d));
            }
        }
    }
    // Interpolation may round above the largest input.
    for (glm::vec3& texel : map.texels) texel = glm::min(texel, glm::vec3(kMaxTexel));
    completeMap(map);
    return map;
}

void completeMap(EnvironmentMap& map) {
    std::uint64_t hash = hashOfBytes(std::as_bytes(std::span(map.texels)), map.faceSize);
    if (map.sun) {
        const std::array<glm::vec3, 2> sun{map.sun->toSun, map.sun->irradiance};
        hash = hashOfBytes(std::as_bytes(std::span(sun)), hash);
    }
    map.contentHash = hash;
    map.harmonics = diffuseHarmonics(map);
    map.harmonicErrors = harmonicErrors(map);
    const glm::vec3 mean = map.harmonics[0];
    map.meanRadiance = std::max({mean.r, mean.g, mean.b, 0.0f});
}

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

const std::vector<glm::vec2>& environmentBrdfTable() {
    static const std::vector<glm::vec2> table = environmentBrdfTable(kEnvironmentBrdfSize);
    return table;
}

}  // namespace clerestory
