// Built-in environment maps: skies, a studio, constants. Each is a function of direction.
#include "scene/environment.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace clerestory {
namespace {

using glm::vec3;

template <class Radiance>
EnvironmentMap drawn(std::string name, std::string title, std::uint32_t faceSize,
                     Radiance&& radiance) {
    EnvironmentMap map{.name = std::move(name), .title = std::move(title), .faceSize = faceSize};
    map.texels.reserve(6 * std::size_t(faceSize) * faceSize);
    for (std::uint32_t face = 0; face < 6; ++face) {
        for (std::uint32_t y = 0; y < faceSize; ++y) {
            for (std::uint32_t x = 0; x < faceSize; ++x) {
                map.texels.push_back(
                    radiance(glm::normalize(cubeTexelDirection(face, x, y, faceSize))));
            }
        }
    }
    return map;
}

// Irradiance / pi on a plane that faces +Y: the radiance of a white floor.
vec3 onFloor(const EnvironmentMap& map) {
    const auto c = diffuseHarmonics(map);
    return c[0] + c[1] - c[6] - c[8];  // the basis at +Y
}

// Scattering towards the eye near the sun (Henyey and Greenstein 1941); 1 on average over all
// directions.
float scattering(float cosine, float g) {
    const float d = 1.0f + g * g - 2.0f * g * cosine;
    return (1.0f - g * g) / (d * std::sqrt(d));
}

// The colours of a sky; linear RGB, unscaled.
struct Air {
    vec3 zenith, horizon, glow, ground;
    vec3 toSun;           // unit
    float hazeHeight;     // sine of the elevation over which the horizon's colour fades by e
    float glowSharpness;  // g of scattering()
    float glowShare;
};

vec3 skyRadiance(const Air& air, const vec3& d) {
    const float up = std::max(d.y, 0.0f);
    const float haze = std::exp(-up / air.hazeHeight);
    // The lower sky is warm on the side of the sun.
    const float across = std::sqrt(std::max(d.x * d.x + d.z * d.z, 1e-12f));
    const float sunAcross = std::max(std::hypot(air.toSun.x, air.toSun.z), 1e-6f);
    const float side = (d.x * air.toSun.x + d.z * air.toSun.z) / (across * sunAcross);
    const float warm = 0.25f * (1.0f + side) * (1.0f + side) * haze;
    const float cosine = glm::dot(d, air.toSun);
    const vec3 sky = glm::mix(air.zenith, air.horizon, haze) + 0.35f * warm * air.glow +
                     air.glowShare * scattering(cosine, air.glowSharpness) * air.glow;
    if (d.y >= 0.0f) return sky;
    // The ground, with haze towards the horizon.
    const float distance = std::exp(d.y * 14.0f);
    return glm::mix(air.ground, sky, distance);
}

}  // namespace

EnvironmentMap skyEnvironment() {
    const Air air{.zenith = {0.075f, 0.20f, 0.54f},
                  .horizon = {0.62f, 0.70f, 0.80f},
                  .glow = {1.00f, 0.80f, 0.52f},
                  .ground = {0.34f, 0.31f, 0.27f},
                  .toSun = glm::normalize(vec3(0.62f, 0.55f, 0.56f)),
                  .hazeHeight = 0.22f,
                  .glowSharpness = 0.80f,
                  .glowShare = 0.04f};
    EnvironmentMap map = drawn("sky", "Clear late afternoon", 256,
                               [&](const vec3& d) { return skyRadiance(air, d); });
    // A white floor has 0.28 from the sky and 0.72 from the sun, suitable for exposure 0.
    const vec3 floor = onFloor(map);
    const float scale = 0.28f / (0.2126f * floor.x + 0.7152f * floor.y + 0.0722f * floor.z);
    for (vec3& texel : map.texels) texel *= scale;
    const vec3 warm(1.19f, 0.98f, 0.66f);  // luminance 1
    map.sun = Sun{.toSun = air.toSun,
                  .irradiance = warm * (0.72f * std::numbers::pi_v<float> / air.toSun.y)};
    completeMap(map);
    return map;
}

namespace {

// A soft box on a wall: 1 inside the rectangle, fading to 0 over `soft` outside of it.
float softBox(float u, float v, float halfWidth, float halfHeight, float soft) {
    const float outside = std::max(std::abs(u) - halfWidth, std::abs(v) - halfHeight);
    return 1.0f - glm::smoothstep(0.0f, soft, outside);
}

// A room of half extents (4, 3, 4) seen from its centre.
vec3 studioRadiance(const vec3& d) {
    const vec3 room(4.0f, 3.0f, 4.0f);
    const vec3 reach = glm::abs(d) / room;
    const float farthest = std::max({reach.x, reach.y, reach.z});  // above 0: d is unit
    const vec3 p = d / farthest;
    const float height = 0.5f + 0.5f * p.y / room.y;
    vec3 light = glm::mix(vec3(0.08f), vec3(0.24f), height);
    if (reach.y == farthest) light = d.y > 0.0f ? vec3(0.26f) : vec3(0.10f);
    // Corners are darker.
    const vec3 toWall = vec3(1.0f) - glm::abs(p) / room;
    const float middle = toWall.x + toWall.y + toWall.z - std::max({toWall.x, toWall.y, toWall.z});
    light *= 0.7f + 0.3f * glm::smoothstep(0.0f, 0.5f, middle);
    if (reach.y == farthest && d.y > 0.0f) {
        light +=
            8.0f * softBox(p.x - 0.6f, p.z - 0.8f, 1.2f, 0.8f, 0.25f) * vec3(1.0f, 0.97f, 0.92f);
    } else if (reach.x == farthest && d.x < 0.0f) {
        light +=
            2.5f * softBox(p.z - 0.4f, p.y - 0.3f, 1.4f, 1.1f, 0.25f) * vec3(0.90f, 0.96f, 1.0f);
    } else if (reach.x == farthest) {
        light +=
            5.0f * softBox(p.z + 2.2f, p.y - 0.4f, 0.4f, 1.6f, 0.2f) * vec3(1.0f, 0.93f, 0.84f);
    }
    return light;
}

}  // namespace

EnvironmentMap studioEnvironment() {
    EnvironmentMap map = drawn("studio", "Grey studio with three soft boxes", 256, studioRadiance);
    completeMap(map);
    return map;
}

EnvironmentMap duskEnvironment() {
    const Air air{.zenith = {0.045f, 0.070f, 0.150f},
                  .horizon = {0.30f, 0.24f, 0.30f},
                  .glow = {1.00f, 0.50f, 0.22f},
                  .ground = {0.035f, 0.032f, 0.035f},
                  .toSun = glm::normalize(vec3(-0.55f, -0.03f, -0.80f)),
                  .hazeHeight = 0.20f,
                  .glowSharpness = 0.55f,
                  .glowShare = 0.05f};
    EnvironmentMap map = drawn("dusk", "Soft evening without a sun", 256,
                               [&](const vec3& d) { return skyRadiance(air, d); });
    completeMap(map);
    return map;
}

EnvironmentMap constantEnvironment(std::string name, const glm::vec3& radiance) {
    std::string title = "The same light from everywhere";
    EnvironmentMap map =
        drawn(std::move(name), std::move(title), 16, [&](const vec3&) { return radiance; });
    completeMap(map);
    return map;
}

std::vector<std::string> builtinEnvironmentNames() {
    return {"sky", "dusk", "studio", "white", "grey", "black"};
}

std::optional<EnvironmentMap> builtinEnvironment(const std::string& name) {
    if (name == "sky") return skyEnvironment();
    if (name == "dusk") return duskEnvironment();
    if (name == "studio") return studioEnvironment();
    if (name == "white") return constantEnvironment(name, vec3(1.0f));
    if (name == "grey") return constantEnvironment(name, vec3(0.18f));
    if (name == "black") return constantEnvironment(name, vec3(0.0f));
    return std::nullopt;
}

}  // namespace clerestory
