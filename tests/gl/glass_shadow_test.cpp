// Shadows of glass and of blended surfaces: the share of a light that reaches a wall behind them.
#include "shadow_support.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

using namespace clerestory;
using namespace clerestory::test;

namespace {

class GlassShadows : public GlTest {};

// Metres of a ray from `from` towards `to` within a ball; of the whole line if `from` is null.
double wayInBall(const std::optional<glm::dvec3>& from, const glm::dvec3& to,
                 const glm::dvec3& centre, double radius) {
    const glm::dvec3 along = from ? glm::normalize(to - *from) : glm::dvec3(0.0, 0.0, -1.0);
    const double middle = glm::dot(centre - to, along);  // of the chord, before `to`: negative
    const double square = radius * radius - glm::dot(centre - to, centre - to) + middle * middle;
    if (square <= 0.0) return 0.0;
    const double half = std::sqrt(square);
    const double begins = from ? std::max(middle - half, -glm::distance(*from, to)) : middle - half;
    return middle + half - begins;
}

// A ball with walls of 0.05 around nothing: light leaves its wall before the middle and enters it
// again.
FrameRequest flaskOverWall(const Light& light, const glm::vec3& attenuation, float distance) {
    Material glass = clearGlass(1.0f);
    glass.thickness = 0.05f;
    glass.attenuationDistance = distance;
    glass.attenuationColor = attenuation;
    Scene scene;
    place(scene, quad(2.0f, addMaterial(scene, lambert(0.5f))));
    MeshDraft flask = sphere(0.25f, 96, addMaterial(scene, glass));
    const MeshDraft inside = sphere(0.2f, 96, 0);
    const auto first = static_cast<Index>(flask.vertices.size());
    flask.vertices.insert(flask.vertices.end(), inside.vertices.begin(), inside.vertices.end());
    for (std::size_t i = 0; i < inside.indices.size(); i += 3) {  // turned inwards
        for (const std::size_t k : {0u, 2u, 1u}) {
            flask.indices.push_back(first + inside.indices[i + k]);
        }
    }
    place(scene, std::move(flask), glm::translate(glm::dmat4(1.0), {0.0, 0.0, 1.3}));
    addLight(scene, light, shiningAlong({0.0, 0.0, 3.0}, {0.0, 0.0, -1.0}));
    return request(std::move(scene), "flask over wall", {0.0, 0.0, 0.9});
}

}  // namespace

// A pane transmits (1 - f) / (1 + f) at normal incidence, with all bounces between its faces, and
// its colour of that; a blended surface what it does not cover.
TEST_F(GlassShadows, GlassCastsItsTint) {
    const float pane = (1.0f - 0.04f) / (1.0f + 0.04f);
    Material coloured = clearGlass();
    coloured.baseColor = {0.9f, 0.4f, 0.1f, 1.0f};
    Material absorbing = clearGlass(1.0f);  // no interface
    absorbing.thickness = 0.5f;
    absorbing.attenuationDistance = 0.25f;
    absorbing.attenuationColor = {0.5f, 0.8f, 1.0f};
    Material veil = lambertBothSides(0.5f);
    veil.alphaMode = AlphaMode::blend;
    veil.baseColor.a = 0.3f;
    const struct {
        Material blocker;
        glm::vec3 left;
    } cases[] = {{clearGlass(), glm::vec3(pane)},
                 {coloured, glm::vec3(0.9f, 0.4f, 0.1f) * pane},
                 {absorbing, {0.25f, 0.64f, 1.0f}},
                 {veil, glm::vec3(0.7f)}};
    for (const auto& [blocker, left] : cases) {
        for (const Light& light : {pointLight(), spotLight(), sunLight()}) {
            const Pictures p = draw(squareOverWall(light, {0.0, 0.0, 3.0}, blocker));
            const glm::vec3 with = centerColor(p.with), without = centerColor(p.without);
            for (int k = 0; k < 3; ++k) {
                EXPECT_NEAR(with[k] / without[k], left[k], 0.01f) << k << ' ' << left[0];
            }
        }
    }
}

// Absorption along the way of the light through a body, from its first face or from the lamp in it.
TEST_F(GlassShadows, BodiesAbsorbAlongTheWayOfTheLight) {
    Material glass = clearGlass(1.0f);  // no interface
    glass.thickness = 0.5f;             // not the way of the light
    glass.attenuationDistance = 0.1f;
    glass.attenuationColor = {0.5f, 0.8f, 0.05f};
    constexpr double kRadius = 0.25;
    const struct {
        const char* name;
        Light light;
        glm::dvec3 at, centre;
    } cases[] = {{"point", pointLight(), {0.0, 0.0, 3.0}, {0.0, 0.0, 1.3}},
                 {"spot", spotLight(), {0.0, 0.0, 3.0}, {0.1, 0.0, 1.3}},
                 {"sun", sunLight(), {0.0, 0.0, 3.0}, {0.0, 0.2, 1.3}},
                 {"lamp inside", pointLight(), {0.0, 0.0, 1.25}, {0.1, 0.0, 1.3}}};
    for (const auto& [name, light, at, centre] : cases) {
        Scene scene;
        place(scene, quad(2.0f, addMaterial(scene, lambert(0.5f))));
        place(scene, sphere(float(kRadius), 96, addMaterial(scene, glass)),
              glm::translate(glm::dmat4(1.0), centre));
        addLight(scene, light, shiningAlong(at, {0.0, 0.0, -1.0}));
        FrameRequest r = request(std::move(scene), "ball over wall", {0.0, 0.0, 0.9});
        r.width = r.height = 201;
        const Pictures p = draw(r);
        double worst = 0.0, least = 1.0;
        for (std::uint32_t y = 0; y < 201; y += 4) {
            for (std::uint32_t x = 0; x < 201; x += 4) {
                const glm::dvec3 wall((x + 0.5) / 201.0 * 1.8 - 0.9, 0.9 - (y + 0.5) / 201.0 * 1.8,
                                      0.0);
                const bool sun = light.kind == LightKind::directional;
                const auto wayIn = [&](double radius) {
                    return wayInBall(sun ? std::nullopt : std::optional(at), wall, centre, radius);
                };
                const double way = wayIn(kRadius);
                // The rim, where it changes within a texel.
                const bool outside = sun || glm::distance(at, centre) > kRadius;
                if (outside && way < kRadius && wayIn(1.1 * kRadius) > 0.0) continue;
                const glm::vec3 ratio = color(p.with, x, y) / color(p.without, x, y);
                for (int k = 0; k < 3; ++k) {
                    const double expected = std::pow(double(glass.attenuationColor[k]), way / 0.1);
                    worst = std::max(worst, std::abs(ratio[k] - expected));
                    least = std::min(least, expected);
                }
            }
        }
        EXPECT_LT(worst, 0.03) << name;
        EXPECT_LT(least, 0.02) << name << ": some light crosses much of the body";
    }
}

TEST_F(GlassShadows, HollowBodiesAbsorbInTheirWalls) {
    const glm::vec3 color(0.5f, 0.8f, 0.2f);
    for (const Light& light : {pointLight(), sunLight()}) {
        const Pictures p = draw(flaskOverWall(light, color, 0.1f));
        const glm::vec3 ratio = centerColor(p.with) / centerColor(p.without);
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(ratio[k], color[k], 0.02f) << k;
    }
}

// Factors of faces that no number can hold: what absorbs is dark, what does not is clear.
TEST_F(GlassShadows, DenseHollowBodiesAreDark) {
    const Pictures p = draw(flaskOverWall(pointLight(), {0.001f, 0.0f, 1.0f}, 1e-4f));
    const glm::vec3 ratio = centerColor(p.with) / centerColor(p.without);
    EXPECT_NEAR(ratio.x, 0.0f, 0.02f);
    EXPECT_NEAR(ratio.y, 0.0f, 0.02f);
    EXPECT_NEAR(ratio.z, 1.0f, 0.02f);
}

TEST_F(GlassShadows, GlassDoesNotTintWhatIsBeforeIt) {
    for (const Light& light : {pointLight(), spotLight(), sunLight()}) {
        Scene scene;
        place(scene, quad(0.5f, addMaterial(scene, lambert(0.5f))), moved(0.0, 0.0, 2.0));
        Material black = clearGlass();
        black.baseColor = {0.0f, 0.0f, 0.0f, 1.0f};
        place(scene, quad(2.0f, addMaterial(scene, black)), moved(0.0, 0.0, 1.0));
        addLight(scene, light, shiningAlong({0.0, 0.0, 4.0}, {0.0, 0.0, -1.0}));
        const Pictures p = draw(request(std::move(scene), "before glass", {0.0, 0.0, 2.5}));
        EXPECT_EQ(centerColor(p.with), centerColor(p.without));
    }
}
