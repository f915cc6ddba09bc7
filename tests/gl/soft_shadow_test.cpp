// Shadows of lights with a radius: the share of a disc that an edge leaves is known.
#include "plan/graph/frame_plan.h"
#include "reference/reference.h"
#include "support.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>
#include <vector>

using namespace clerestory;
using namespace clerestory::test;

namespace {

class SoftShadows : public GlTest {};

Light lightOf(LightKind kind, double radius) {
    return {.kind = kind,
            .intensity = glm::vec3(kind == LightKind::directional ? 2.0f : 8.0f),
            .innerConeAngle = 1.0f,
            .outerConeAngle = 1.1f,
            .radius = static_cast<float>(radius)};
}

// A wall at z = 0. Half of what is at z = 1, that of negative x, hides a light at z = 3, straight
// over the edge. `size`: factor on all lengths.
FrameRequest edgeOverWall(Light light, double size = 1.0) {
    Scene scene;
    const auto s = static_cast<float>(size);
    Material white;
    white.metallic = 0.0f;
    white.specular = 0.0f;
    place(scene, quad(4.0f * s, addMaterial(scene, white)));
    white.doubleSided = true;
    place(scene, quad(2.0f * s, addMaterial(scene, white)), moved(-2.0 * size, 0.0, size));
    light.name = "lamp";
    if (light.kind != LightKind::directional) {
        light.intensity *= s * s;
        light.radius *= s;
    }
    addLight(scene, light, moved(0.0, 0.0, 3.0 * size));
    FrameRequest r = request(std::move(scene), "edge over wall", size * glm::dvec3(0.0, 0.0, 0.95));
    r.camera.znear = 0.01 * size;
    r.width = r.height = 128;
    return r;
}

// Of a disc of radius 1, the area right of a line at c.
double shareRightOf(double c) {
    c = std::clamp(c, -1.0, 1.0);
    return (std::acos(c) - c * std::sqrt(1.0 - c * c)) / std::numbers::pi;
}

struct Deviation {
    double mean = 0.0, largest = 0.0;
};

// From the share of the disc, over the wall's points within twice the half shadow. penumbra: half
// of its width.
Deviation deviation(FrameRequest r, double penumbra) {
    const Image without = renderer().render(r).image;
    r.effects.shadows = true;
    const Image with = renderer().render(r).image;
    Deviation found;
    int count = 0;
    for (std::uint32_t x = 0; x < 128; ++x) {
        const double at = ((x + 0.5) / 64.0 - 1.0) * 0.95;
        if (std::abs(at) > 2.0 * penumbra) continue;
        for (std::uint32_t y = 32; y < 96; y += 9, ++count) {
            const double seen = color(with, x, y).x / color(without, x, y).x;
            const double error = std::abs(seen - shareRightOf(-at / penumbra));
            found.mean += error;
            found.largest = std::max(found.largest, error);
        }
    }
    found.mean /= count;
    return found;
}

}  // namespace

// The lamp is twice as far from the edge as the wall is: half shadows are half as wide as the lamp.
// A directional light of radius r has half shadows of r to each side at a distance of 1.
TEST_F(SoftShadows, AnEdgeShowsTheShareOfTheDisc) {
    for (const LightKind kind : {LightKind::point, LightKind::spot, LightKind::directional}) {
        for (const double radius : {0.1, 0.3, 0.8}) {
            for (const Preset preset : {Preset::draft, Preset::standard, Preset::fine}) {
                FrameRequest r = edgeOverWall(lightOf(kind, radius));
                r.accuracy = accuracyOf(preset);
                r.accuracy.edgeFilter = false;
                const Deviation d =
                    deviation(r, kind == LightKind::directional ? radius : 0.5 * radius);
                const std::string name = std::to_string(static_cast<int>(kind)) + ' ' +
                                         std::to_string(radius) + ' ' +
                                         std::to_string(static_cast<int>(preset));
                const auto i = static_cast<std::size_t>(preset);
                EXPECT_LT(d.mean, (std::array{0.07, 0.03, 0.02})[i]) << name;
                EXPECT_LT(d.largest, (std::array{0.4, 0.25, 0.2})[i]) << name;
            }
        }
    }
}

TEST_F(SoftShadows, ScaleDoesNotMatter) {
    for (const double size : {1e-3, 1e4}) {
        for (const LightKind kind : {LightKind::point, LightKind::directional}) {
            const Deviation d = deviation(edgeOverWall(lightOf(kind, 0.3), size),
                                          kind == LightKind::directional ? 0.3 : 0.15);
            EXPECT_LT(d.mean, 0.03) << size;
        }
    }
}

// Without a radius nothing changes, and one that is larger than the scene stays finite.
TEST_F(SoftShadows, AnyRadiusIsFinite) {
    FrameRequest r = edgeOverWall(lightOf(LightKind::point, 0.3));
    r.effects.shadows = true;
    const Image soft = renderer().render(r).image;
    r.lights = {{.light = "lamp", .radius = 0.0}};
    const Image sharp = renderer().render(r).image;
    EXPECT_NE(std::memcmp(soft.data.data(), sharp.data.data(), sharp.data.size()), 0);
    const Image point = [&] {
        FrameRequest q = edgeOverWall(lightOf(LightKind::point, 0.0));
        q.effects.shadows = true;
        return renderer().render(q).image;
    }();
    EXPECT_EQ(std::memcmp(point.data.data(), sharp.data.data(), sharp.data.size()), 0);
    for (const LightKind kind : {LightKind::point, LightKind::spot, LightKind::directional}) {
        FrameRequest huge = edgeOverWall(lightOf(kind, 1.0));
        huge.effects.shadows = true;
        huge.lights = {{.radius = 1e9}};
        const Image image = renderer().render(huge).image;
        for (std::uint32_t y = 0; y < image.height; y += 3) {
            for (std::uint32_t x = 0; x < image.width; x += 3) {
                const float seen = color(image, x, y).x;
                EXPECT_TRUE(std::isfinite(seen) && seen >= 0.0f);
            }
        }
    }
}

TEST_F(SoftShadows, AnUnknownLightIsNamed) {
    FrameRequest r = edgeOverWall(lightOf(LightKind::point, 0.3));
    r.lights = {{.light = "lomp", .radius = 0.1}};
    try {
        renderer().render(r);
        FAIL();
    } catch (const InvalidRequest& error) {
        ASSERT_EQ(error.errors().size(), 1u);
        EXPECT_EQ(error.errors()[0].pointer, "/lights/0/light");
        EXPECT_NE(error.errors()[0].detail.find("did you mean \"lamp\""), std::string::npos);
    }
}

// The highlight of a lamp with a radius is wider, as the path tracer has it.
TEST_F(SoftShadows, HighlightsShowTheDiscOfTheLamp) {
    const EnvironmentMap black = constantEnvironment("black", glm::vec3(0.0f));
    for (const LightKind kind : {LightKind::point, LightKind::directional}) {
        Scene scene;
        place(scene, quad(4.0f, addMaterial(scene, {.baseColor = glm::vec4(0.0f, 0.0f, 0.0f, 1.0f),
                                                    .metallic = 0.0f,
                                                    .roughness = 0.35f})));
        // It reflects towards the eye from the origin.
        const double elevation = 0.9, away = 2.0;
        const glm::dvec3 towards(std::cos(elevation), 0.0, std::sin(elevation));
        addLight(scene, lightOf(kind, kind == LightKind::point ? 0.5 : 0.25),
                 moved(-away * towards.x, 0.0, away * towards.z) *
                     glm::rotate(glm::dmat4(1.0), elevation - 0.5 * std::numbers::pi,
                                 glm::dvec3(0.0, 1.0, 0.0)));
        for (const double x : {0.0, 0.15, 0.3}) {
            FrameRequest r = request(Scene(scene), "disc", glm::dvec3(x, 0.0, 0.0) + 1.5 * towards);
            r.camera.target = {x, 0.0, 0.0};
            r.camera.yfov = 0.02;
            r.width = r.height = 5;
            r.effects.shadows = true;
            const auto truth = traceReference({.scene = scene,
                                               .frame = r,
                                               .environment = black,
                                               .mode = ReferenceMode::full,
                                               .samples = 1024});
            EXPECT_NEAR(centerColor(renderer().render(r).image).x / truth->color.floats()[3 * 12],
                        1.0, 0.12)
                << static_cast<int>(kind) << ' ' << x;
        }
    }
}

// Two ways to one picture: the highlight of a light with a radius on smooth metal is that of many
// points on its disc, next to the highlight too, where no haze surrounds it.
TEST_F(SoftShadows, HighlightsAreThoseOfPointsOnTheDisc) {
    constexpr double kRadius = 0.15;
    constexpr int kPictures = 12, kPoints = 8;  // of the points of one picture
    constexpr std::uint32_t kSize = 64;
    const auto drawn = [](const Light& light, const std::vector<glm::dvec2>& places) {
        Scene scene;
        place(scene, quad(1.0f, addMaterial(scene, mirrorMetal(0.8f, 0.2f))));
        for (const glm::dvec2& at : places) addLight(scene, light, moved(at.x, at.y, 1.0));
        FrameRequest r = request(std::move(scene), "disc", {0.1, 0.0, 1.0});
        r.width = r.height = kSize;
        r.accuracy.planar = PlanarMethod::environment;
        return renderer().render(r).image;
    };
    const Image disc = drawn({.intensity = glm::vec3(1.0f), .radius = float(kRadius)}, {{0, 0}});
    std::vector<double> points(kSize * kSize);
    for (int picture = 0; picture < kPictures; ++picture) {
        std::vector<glm::dvec2> places;
        for (int i = picture; i < kPictures * kPoints; i += kPictures) {  // a spiral
            const double away = kRadius * std::sqrt((i + 0.5) / (kPictures * kPoints));
            places.emplace_back(away * std::cos(2.399963 * i), away * std::sin(2.399963 * i));
        }
        const Image image =
            drawn({.intensity = glm::vec3(1.0f / float(kPictures * kPoints))}, places);
        for (std::uint32_t i = 0; i < points.size(); ++i) {
            points[i] += color(image, i % kSize, i / kSize).x;
        }
    }
    const double peak = *std::max_element(points.begin(), points.end());
    double expected = 0.0, found = 0.0;  // next to the highlight
    for (std::uint32_t i = 0; i < points.size(); ++i) {
        const double shown = color(disc, i % kSize, i / kSize).x;
        EXPECT_NEAR(shown, points[i], 0.15 * peak) << i % kSize << ' ' << i / kSize;
        if (points[i] > 0.05 * peak) continue;
        expected += points[i];
        found += shown;
    }
    EXPECT_NEAR(found / expected, 1.0, 0.25);
}
