// Layers of materials: furnaces, the path tracer's pictures, and what they cost where there are
// none.
#include "own_sky.h"
#include "plan/graph/features.h"
#include "reference/reference.h"

#include <algorithm>
#include <cmath>

namespace clerestory::test {
namespace {

class MaterialLayers : public GlTest {};

Material base(const glm::vec3& color, float metallic, float roughness) {
    return {.baseColor = glm::vec4(color, 1.0f),
            .metallic = metallic,
            .roughness = roughness,
            .reflection = Reflection::none};
}

Material coated(Material m, float share, float roughness) {
    m.clearcoat = share;
    m.clearcoatRoughness = roughness;
    return m;
}
Material withSheen(Material m, const glm::vec3& color, float roughness) {
    m.sheenColor = color;
    m.sheenRoughness = roughness;
    return m;
}
Material withFilm(Material m, float share, float nanometres) {
    m.iridescence = share;
    m.iridescenceThickness = nanometres;
    return m;
}
Material withGrain(Material m, float strength, float rotation = 0.0f) {
    m.anisotropy = strength;
    m.anisotropyRotation = rotation;
    return m;
}
Material translucent(Material m, float share, const glm::vec3& color) {
    m.diffuseTransmission = share;
    m.diffuseTransmissionColor = color;
    m.doubleSided = true;
    return m;
}

FrameRequest ball(const Material& material, const char* map) {
    Scene scene;
    place(scene, sphere(1.0f, 48, addMaterial(scene, material)));
    FrameRequest r = request(std::move(scene), "layers");
    r.environment.map = map;
    return r;
}

// The grid of a layer's parameters over white bases, dielectric and metal.
std::vector<Material> whiteGrid() {
    std::vector<Material> grid;
    for (const float metallic : {0.0f, 1.0f}) {
        for (const float roughness : {0.1f, 0.7f}) {
            const Material white = base(glm::vec3(1.0f), metallic, roughness);
            for (const float share : {0.5f, 1.0f}) {
                for (const float x : {0.0f, 0.1f, 0.3f, 0.6f, 1.0f}) {
                    grid.push_back(coated(white, share, x));
                    grid.push_back(withSheen(white, glm::vec3(share), x));
                    grid.push_back(withFilm(white, share, 1000.0f * x));
                    grid.push_back(withGrain(white, x, share));
                    grid.push_back(translucent(white, x, glm::vec3(share)));
                    grid.push_back(coated(
                        withSheen(withFilm(white, 1.0f, 400.0f), glm::vec3(x), share), x, x));
                }
            }
        }
    }
    return grid;
}

TEST_F(MaterialLayers, ReturnAtMostTheLightOfAFurnace) {
    for (const Material& m : whiteGrid()) {
        const Image image = renderer().render(ball(m, "white")).image;
        float greatest = 0.0f;
        for (std::uint32_t y = 0; y < image.height; ++y) {
            for (std::uint32_t x = 0; x < image.width; ++x) {
                const glm::vec3 c = color(image, x, y);
                greatest = std::max({greatest, c.x, c.y, c.z});
            }
        }
        ASSERT_LE(greatest, 1.01f) << m.clearcoat << ' ' << m.sheenColor.x << ' ' << m.iridescence
                                   << ' ' << m.anisotropy << ' ' << m.diffuseTransmission;
    }
}

// The same with rays in place of the environment's lobe. They meet nothing else.
TEST_F(MaterialLayers, RaysReturnAtMostTheLightOfAFurnace) {
    for (Material m : whiteGrid()) {
        if (m.metallic == 0.0f || m.roughness > 0.5f) continue;  // others are not ray traced
        m.reflection = Reflection::automatic;
        FrameRequest r = ball(m, "white");
        r.accuracy.curved = CurvedMethod::traced;
        const Image image = renderer().render(r).image;
        float greatest = 0.0f;
        for (std::uint32_t y = 0; y < image.height; ++y) {
            for (std::uint32_t x = 0; x < image.width; ++x) {
                greatest = std::max(greatest, color(image, x, y).x);
            }
        }
        ASSERT_LE(greatest, 1.01f) << m.clearcoat << ' ' << m.sheenColor.x << ' ' << m.iridescence
                                   << ' ' << m.anisotropy << ' ' << m.diffuseTransmission;
    }
}

// Of the path tracer the mean over the ball, but for its noise: single paths may weigh more than 1.
TEST_F(MaterialLayers, TheReferenceReturnsAtMostTheLightOfAFurnace) {
    const EnvironmentMap white = *builtinEnvironment("white");
    for (const Material& m : whiteGrid()) {
        Scene scene;
        place(scene, sphere(1.0f, 24, addMaterial(scene, m)));
        const Scene copy = scene;
        FrameRequest r = request(std::move(scene), "furnace");
        r.environment.map = "white";
        r.width = r.height = 16;
        const auto traced =
            traceReference({.scene = copy, .frame = r, .environment = white, .samples = 16}, {});
        double sum = 0.0, variance = 0.0;
        for (std::uint32_t y = 4; y < 12; ++y) {  // within the ball's outline
            for (std::uint32_t x = 4; x < 12; ++x) {
                const double noise = color(traced->noise, x, y).x;
                sum += double{color(traced->color, x, y).x};
                variance += noise * noise;
            }
        }
        ASSERT_LE(sum / 64.0, 1.002 + 3.0 * std::sqrt(variance) / 64.0)
            << m.clearcoat << ' ' << m.sheenColor.x << ' ' << m.iridescence << ' ' << m.anisotropy
            << ' ' << m.diffuseTransmission;
        ASSERT_GT(sum / 64.0, 0.4);
    }
}

// What a layer does not reflect, the white base below it returns.
TEST_F(MaterialLayers, OverWhiteLoseNothing) {
    const Material white = base(glm::vec3(1.0f), 0.0f, 0.5f);
    for (const Material& m : {coated(white, 1.0f, 0.0f), coated(white, 0.5f, 0.4f),
                              withSheen(white, glm::vec3(1.0f), 0.5f), withGrain(white, 0.5f),
                              translucent(white, 0.4f, glm::vec3(1.0f))}) {
        const Image image = renderer().render(ball(m, "white")).image;
        for (std::uint32_t y = 0; y < image.height; ++y) {
            for (std::uint32_t x = 0; x < image.width; ++x) {
                ASSERT_NEAR(color(image, x, y).x, 1.0f, 0.01f) << x << ' ' << y;
            }
        }
    }
}

// A smooth coat on black reflects 4 % of a white furnace at normal incidence (index 1.5).
TEST_F(MaterialLayers, ACoatReflectsAsGlassDoes) {
    Material black = base(glm::vec3(0.0f), 0.0f, 1.0f);
    black.specular = 0.0f;
    EXPECT_NEAR(centerColor(renderer().render(ball(coated(black, 1.0f, 0.0f), "white")).image).x,
                0.04f, 0.001f);
    EXPECT_NEAR(centerColor(renderer().render(ball(coated(black, 0.25f, 0.0f), "white")).image).x,
                0.01f, 0.001f);
}

// Light behind a sheet: its other side's irradiance over pi, times the colour and the share of what
// the surface does not reflect (4 % at normal incidence, 9.2 % over the hemisphere).
TEST_F(MaterialLayers, ASheetShowsTheLightBehindIt) {
    addMap("behind", 32, glm::dmat3(1.0),
           [](const glm::dvec3& d) { return glm::vec3(d.z < 0.0 ? 2.0f : 0.0f); });
    Material sheet = translucent(base(glm::vec3(0.3f), 0.0f, 1.0f), 0.6f, {0.2f, 0.5f, 1.0f});
    sheet.specular = 0.0f;
    Scene scene;
    place(scene, quad(1.0f, addMaterial(scene, sheet)));
    FrameRequest r = request(std::move(scene), "sheet", {0, 0, 1});
    r.environment.map = "behind";
    r.camera.target = glm::dvec3(0.0);
    const glm::vec3 c = centerColor(renderer().render(r).image);
    // Nine harmonics of a hemisphere keep its irradiance about the axis to 1 %.
    EXPECT_NEAR(c.x, 2.0f * 0.6f * 0.2f, 0.01f);
    EXPECT_NEAR(c.y, 2.0f * 0.6f * 0.5f, 0.02f);
    EXPECT_NEAR(c.z, 2.0f * 0.6f * 1.0f, 0.04f);
}

// A punctual light behind the sheet: its cosine, over pi.
TEST_F(MaterialLayers, ASheetIsLitFromBehind) {
    Material sheet = translucent(base(glm::vec3(0.0f), 0.0f, 1.0f), 0.5f, {0.2f, 0.4f, 0.8f});
    sheet.specular = 0.0f;
    Scene scene;
    place(scene, quad(1.0f, addMaterial(scene, sheet)));
    Light sun{.kind = LightKind::directional, .intensity = glm::vec3(3.0f)};
    glm::dmat4 turned(1.0);  // shines along +Z
    turned[0][0] = turned[2][2] = -1.0;
    addLight(scene, sun, turned);
    FrameRequest r = request(std::move(scene), "lit sheet", {0, 0, 1});
    const float expected = 3.0f * 0.5f / 3.14159265f;
    for (const bool shadows : {false, true}) {  // the sheet does not shadow itself
        r.effects.shadows = shadows;
        const glm::vec3 c = centerColor(renderer().render(r).image);
        EXPECT_NEAR(c.x, 0.2f * expected, 1e-3f) << shadows;
        EXPECT_NEAR(c.z, 0.8f * expected, 4e-3f) << shadows;
    }
}

// A ball under the sky, compared with the path tracer. Largest differences of the means: Schlick's
// curve of a coat over a dark base (6 %), colours of films (9 %).
TEST_F(MaterialLayers, LookAsInTheReference) {
    const EnvironmentMap sky = *builtinEnvironment("sky");
    const Material red = base({0.5f, 0.1f, 0.1f}, 0.0f, 0.6f);
    const Material cloth = base(glm::vec3(0.05f), 0.0f, 0.8f);
    const Material gold = base({0.9f, 0.7f, 0.4f}, 1.0f, 0.4f);
    const Material dark = base(glm::vec3(0.02f), 0.0f, 0.2f);
    const Material thinGlass = clearGlass();
    Material lens = clearGlass();  // of sunglasses
    lens.baseColor = {0.03f, 0.03f, 0.04f, 1.0f};
    Material solidGlass = clearGlass();
    solidGlass.thickness = 2.0f;
    struct Case {
        const char* name;
        Material material;
    };
    const Case cases[] = {{"coat", coated(red, 1.0f, 0.0f)},
                          {"rough coat", coated(red, 1.0f, 0.5f)},
                          {"narrow sheen", withSheen(cloth, {0.9f, 0.6f, 0.3f}, 0.3f)},
                          {"wide sheen", withSheen(cloth, {0.9f, 0.6f, 0.3f}, 0.8f)},
                          {"thin film", withFilm(dark, 1.0f, 250.0f)},
                          {"thick film", withFilm(dark, 1.0f, 500.0f)},
                          {"film on metal", withFilm(gold, 1.0f, 400.0f)},
                          {"film on a thin pane", withFilm(thinGlass, 1.0f, 350.0f)},
                          {"film on a dark pane", withFilm(lens, 1.0f, 350.0f)},
                          {"film on solid glass", withFilm(solidGlass, 1.0f, 350.0f)},
                          {"grain", withGrain(gold, 0.6f)},
                          {"turned grain", withGrain(gold, 0.6f, 0.8f)},
                          {"sheet", translucent(red, 0.6f, {0.2f, 0.8f, 0.3f})}};
    for (const Case& c : cases) {
        Scene scene;
        place(scene, sphere(1.0f, 48, addMaterial(scene, c.material)));
        const Scene copy = scene;
        FrameRequest r = request(std::move(scene), "truth");
        r.environment.map = "sky";
        const Image drawn = renderer().render(r).image;
        const Image truth =
            traceReference({.scene = copy, .frame = r, .environment = sky, .samples = 64}, {})
                ->color;
        glm::dvec3 sum(0.0), expected(0.0);
        for (std::uint32_t y = 16; y < 48; ++y) {  // within the ball's outline
            for (std::uint32_t x = 16; x < 48; ++x) {
                sum += glm::dvec3(color(drawn, x, y));
                expected += glm::dvec3(color(truth, x, y));
            }
        }
        for (int i = 0; i < 3; ++i) {
            EXPECT_NEAR(sum[i] / expected[i], 1.0, 0.1) << c.name << " channel " << i;
            EXPECT_GT(sum[i] / 1024.0, 0.005) << c.name << " is not black";
        }
    }
}

// Without layers the switch changes neither bytes nor programs.
TEST_F(MaterialLayers, CostNothingWhereThereAreNone) {
    FrameRequest r = ball(base({0.5f, 0.3f, 0.2f}, 0.5f, 0.4f), "sky");
    const Frame with = renderer().render(r);
    r.effects.materialLayers = false;
    const Frame without = renderer().render(r);
    EXPECT_EQ(with.image.data, without.image.data);
    EXPECT_EQ(toText(with.plan), toText(without.plan));
}

TEST_F(MaterialLayers, OffEqualsTheBaseAlone) {
    const Material plain = base({0.5f, 0.3f, 0.2f}, 0.5f, 0.4f);
    const auto bare = renderer().render(ball(plain, "sky")).image.data;
    for (const Material& m : {coated(plain, 1.0f, 0.1f), withSheen(plain, glm::vec3(1.0f), 0.3f),
                              withFilm(plain, 1.0f, 300.0f), withGrain(plain, 0.7f)}) {
        FrameRequest r = ball(m, "sky");
        EXPECT_NE(renderer().render(r).image.data, bare);
        r.effects.materialLayers = false;
        EXPECT_EQ(renderer().render(r).image.data, bare);
    }
}

// Varnish on a matt table mirrors what stands on it.
TEST_F(MaterialLayers, AFlatCoatMirrorsTheScene) {
    const auto table = [&](float share) {
        Scene scene;
        Material wood = coated(base(glm::vec3(0.0f), 0.0f, 1.0f), share, 0.0f);
        wood.specular = 0.0f;
        wood.reflection = Reflection::automatic;
        glm::dmat4 lying(1.0);
        lying[1] = {0, 0, -1, 0};
        lying[2] = {0, 1, 0, 0};
        place(scene, quad(4.0f, addMaterial(scene, wood)), lying);
        place(scene, quad(4.0f, addMaterial(scene, glowing(glm::vec3(2.0f)))), moved(0, 0, -3));
        FrameRequest r = request(std::move(scene), "table", {0, 1, 1});
        r.camera.target = glm::dvec3(0, 0, 0);
        r.accuracy.planar = PlanarMethod::mirror;
        return renderer().render(r);
    };
    const Frame varnished = table(1.0f);
    // At 45 degrees Schlick's curve of 4 % is at 4.2 %.
    EXPECT_NEAR(centerColor(varnished.image).x, 2.0f * 0.0421f, 2e-3f);
    EXPECT_EQ(centerColor(table(0.0f).image).x, 0.0f);
}

}  // namespace
}  // namespace clerestory::test
