// Look-ups of a map along the lobe of a rough metal at an angle, compared with the GGX integral by
// quadrature.
#include "own_sky.h"
#include "plan/graph/features.h"
#include "sight.h"

#include <numbers>
#include <utility>

namespace clerestory::test {
namespace {

class CurvedSamples : public GlTest {};

Material roughMetal(float roughness) {
    Material m = mirrorMetal(1.0f, roughness);
    m.reflection = roughness > 0.5f ? Reflection::automatic : Reflection::mirror;
    return m;
}

// Dark below the horizon and at it, bright above, and one bright patch.
glm::vec3 evening(const glm::dvec3& d) {
    const double up = std::max(d.z, 0.0);
    const double patch = std::max(glm::dot(d, glm::normalize(glm::dvec3(0.5, 0.7, 0.5))), 0.0);
    return glm::vec3(float(0.05 + 2.0 * up * up + 3.0 * std::pow(patch, 16.0)));
}

// The radiance of a white rough metal (normal +Z) under the evening map: the normalised mean over
// the lobe. Walter (2007), Heitz (2014); over half vectors.
double lobeMean(const glm::dvec3& v, double roughness) {
    const double alpha = roughness * roughness, a2 = alpha * alpha;
    const auto root = [&](double c) { return std::sqrt(a2 + (1.0 - a2) * c * c); };
    double light = 0.0, all = 0.0;
    const int rings = 300, turns = 128;
    for (int i = 0; i < rings; ++i) {
        const double x = (i + 0.5) / rings, tangent = alpha * x / (1.0 - x);
        const double c = 1.0 / std::sqrt(1.0 + tangent * tangent), s = tangent * c;
        const double k = c * c * (a2 - 1.0) + 1.0;
        const double solid = s * c * c / ((1.0 - x) * (1.0 - x)) / (k * k);
        for (int turn = 0; turn < turns; ++turn) {
            const double phi = 2.0 * std::numbers::pi * (turn + 0.5) / turns;
            const glm::dvec3 h(s * std::cos(phi), s * std::sin(phi), c);
            const double vh = glm::dot(v, h);
            const glm::dvec3 l = 2.0 * vh * h - v;
            if (vh <= 0.0 || l.z <= 0.0) continue;
            const double weight = solid * vh * l.z / (l.z * root(v.z) + v.z * root(l.z));
            light += weight * double(evening(l).x);
            all += weight;
        }
    }
    return light / all;
}

FrameRequest sampled(Scene scene, const char* map, std::uint32_t samples) {
    FrameRequest r = request(std::move(scene), "rough metal");
    r.environment.map = map;
    r.environment.visible = false;
    r.effects.planarReflection = false;
    r.accuracy.curved = CurvedMethod::environment;
    r.accuracy.environmentSamples = 256;
    r.accuracy.curvedSamples = samples;
    return r;
}

// A plane of it, seen at n.v from 0.05 to 0.35: root mean square of the relative error.
double errorAtGrazing(float roughness, std::uint32_t samples) {
    Scene scene;
    place(scene, quad(400.0f, addMaterial(scene, roughMetal(roughness))));
    FrameRequest r = sampled(std::move(scene), "evening", samples);
    r.camera.position = glm::dvec3(0, -5, 1);
    r.camera.target = glm::dvec3(0, 0, 0);
    r.camera.up = glm::dvec3(0, 0, 1);
    r.camera.yfov = 0.5;
    const Image image = renderer().render(r).image;
    double squares = 0.0;
    int compared = 0;
    for (std::uint32_t y = 0; y < r.height; ++y) {
        for (const std::uint32_t x : {0u, 20u, 40u, 60u}) {
            const glm::dvec3 v = -sightOfPixel(r, x, y).direction;
            if (v.z < 0.05 || v.z > 0.35) continue;
            const double off = double{color(image, x, y).x} / lobeMean(v, double{roughness}) - 1.0;
            squares += off * off;
            ++compared;
        }
    }
    EXPECT_GT(compared, 60);
    return std::sqrt(squares / compared);
}

// One look-up in the mirror's direction, as wide as the lobe seen from its own normal, has 0.39 to
// 0.48.
TEST_F(CurvedSamples, AreCloserToTheGgxIntegralThanOneLookup) {
    addMap("evening", 128, glm::dmat3(1.0), evening);
    for (const auto& [roughness, bound] :
         {std::pair{0.35f, 0.40}, {0.5f, 0.14}, {0.7f, 0.15}, {0.9f, 0.10}}) {
        const double single = errorAtGrazing(roughness, 0);
        EXPECT_LT(single, bound) << roughness;
        EXPECT_LT(errorAtGrazing(roughness, 4), 0.85 * single) << roughness;
        EXPECT_LT(errorAtGrazing(roughness, 6), 0.65 * single) << roughness;
        EXPECT_LT(errorAtGrazing(roughness, 16), 0.09) << roughness;
    }
}

TEST_F(CurvedSamples, VanishInAWhiteFurnace) {
    for (const float roughness : {0.2f, 0.25f, 0.4f, 0.6f, 0.8f, 1.0f}) {
        Scene scene;
        place(scene, sphere(0.9f, 64, addMaterial(scene, roughMetal(roughness))));
        const Image image = renderer().render(sampled(std::move(scene), "white", 16)).image;
        for (std::uint32_t i = 0; i < 64 * 64; ++i) {
            const float seen = color(image, i % 64, i / 64).x;
            ASSERT_TRUE(seen == 0.0f || std::abs(seen - 1.0f) < 0.01f)
                << seen << " at " << roughness;
        }
    }
}

// No byte changes for smooth surfaces, and towards normal incidence.
TEST_F(CurvedSamples, ChangeOnlyRoughSurfacesAtAngles) {
    addMap("evening", 128, glm::dmat3(1.0), evening);
    const auto picture = [](float roughness, std::uint32_t samples) {
        Scene scene;
        place(scene, sphere(0.9f, 48, addMaterial(scene, roughMetal(roughness))));
        return renderer().render(sampled(std::move(scene), "evening", samples)).image;
    };
    EXPECT_EQ(picture(0.1f, 16).data, picture(0.1f, 0).data);
    const Image with = picture(0.6f, 16), without = picture(0.6f, 0);
    int changed = 0;
    for (std::uint32_t y = 0; y < 64; ++y) {
        for (std::uint32_t x = 0; x < 64; ++x) {
            const Ray ray{{0, 0, 2}, glm::normalize(glm::dvec3(x + 0.5 - 32, 31.5 - y, -32))};
            const auto t = meetsBall(ray, {0, 0, 0}, 0.9);
            const double off = greatestDifference(color(with, x, y), color(without, x, y));
            if (!t) continue;
            const double nDotV = -glm::dot(ray.origin + *t * ray.direction, ray.direction) / 0.9;
            if (nDotV > 0.7) {
                EXPECT_EQ(off, 0.0) << x << ' ' << y;
            }
            changed += off > 0.005;
        }
    }
    EXPECT_GT(changed, 50);
}

}  // namespace
}  // namespace clerestory::test
