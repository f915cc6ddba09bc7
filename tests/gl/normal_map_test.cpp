// Normal maps of flat mirrors: the reflection is uneven.
#include "measures/errors.h"
#include "reference/reference.h"
#include "scene/environment.h"
#include "scene/normal_maps.h"
#include "scene/texture_images.h"
#include "support.h"

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <cmath>
#include <functional>

namespace clerestory::test {
namespace {

class NormalMaps : public GlTest {};

// A texture whose texels are made from their column and row.
Index addImage(Scene& scene, std::uint32_t edge,
               const std::function<glm::u8vec4(std::uint32_t, std::uint32_t)>& texelAt) {
    TextureImage image{.width = edge, .height = edge, .colorSpace = ColorSpace::linear};
    for (std::uint32_t y = 0; y < edge; ++y) {
        for (std::uint32_t x = 0; x < edge; ++x) {
            const glm::u8vec4 t = texelAt(x, y);
            image.texels.insert(image.texels.end(), {t.x, t.y, t.z, t.w});
        }
    }
    buildLevels(image);
    scene.images.push_back(std::move(image));
    scene.textures.push_back({.image = static_cast<Index>(scene.images.size() - 1)});
    return static_cast<Index>(scene.textures.size() - 1);
}

glm::u8vec4 texelOf(const glm::dvec3& normal) {
    return glm::u8vec4(glm::u8vec3(glm::round(127.5 * (normal + 1.0))), 255);
}

MeshDraft sheet(float half, Index material) {
    MeshDraft draft = quad(half, material);
    draft.hasTangents = true;
    for (Vertex& v : draft.vertices) v.tangent = {1, 0, 0, 1};
    return draft;
}

// A metal floor with waves in its normal map, below a glowing box.
Scene wavedFloor(double slope) {
    Scene scene;
    Material floor = mirrorMetal(0.9f, 0.05f);
    floor.normalTexture.texture = addImage(scene, 128, [&](std::uint32_t x, std::uint32_t y) {
        const double turn = 2.0 * glm::pi<double>() / 128.0;
        const double u = slope * std::sin(3.0 * turn * x), v = slope * std::sin(2.0 * turn * y);
        return texelOf(glm::normalize(glm::dvec3(-u, -v, 1.0)));
    });
    place(scene, sheet(3.0f, addMaterial(scene, floor)),
          glm::rotate(glm::dmat4(1.0), -glm::half_pi<double>(), glm::dvec3(1, 0, 0)));
    const Index red = addMaterial(scene, glowing({0.9f, 0.2f, 0.1f}));
    const Index green = addMaterial(scene, glowing({0.2f, 0.8f, 0.3f}));
    for (int side = 0; side < 4; ++side) {
        const glm::dmat4 turned =
            glm::rotate(moved(0, 0.7, -0.3), side * glm::half_pi<double>(), glm::dvec3(0, 1, 0));
        place(scene, quad(0.5f, side % 2 ? red : green), turned * moved(0, 0, 0.5));
    }
    packNormals(scene);
    return scene;
}

// The reflection on the floor, drawn at `standard`, is nearer to the reference than that without
// the effect; a mirrored view, which knows no bumps, is further away than either.
TEST_F(NormalMaps, UnevenMirrorsAreNearerToTheTruthThanNone) {
    const EnvironmentMap sky = *builtinEnvironment("sky");
    for (const double slope : {0.05, 0.1, 0.2}) {
        Scene scene = wavedFloor(slope);
        const Scene copy = scene;
        FrameRequest r = request(std::move(scene), "waves", {0, 1.6, 3.2});
        r.camera.target = glm::dvec3(0, 0.2, 0);
        r.camera.yfov = 0.8;
        r.environment.map = "sky";
        r.width = 160;
        r.height = 90;
        const ReferenceImage truth =
            *traceReference({.scene = copy, .frame = r, .environment = sky, .samples = 64}, {});
        Mask floor{.width = r.width, .height = r.height};
        for (const std::uint32_t id : truth.objectId) floor.inside.push_back(id == 1);
        const auto errorOf = [&](const FrameRequest& frame) {
            return linearErrors(renderer().render(frame).image, truth.color, &floor).relMse;
        };
        const double standard = errorOf(r);
        FrameRequest without = r, flat = r;
        without.effects.planarReflection = false;
        flat.accuracy.planar = PlanarMethod::mirror;
        const double off = errorOf(without), mirrored = errorOf(flat);
        std::printf("slope %.2f: relMSE %.4f, without the effect %.4f, as a flat mirror %.4f\n",
                    slope, standard, off, mirrored);
        EXPECT_LT(standard, 0.5 * off) << slope;
        EXPECT_LE(standard, 0.023) << slope;
        EXPECT_GT(mirrored, (slope < 0.1 ? 1.5 : 5.0) * standard) << slope;
    }
}

// A glossy sheet with waves of ten texels in the normal map of the metal or of a coat over black,
// in the sun.
Scene wavedSheet(float roughness, double slope, bool ofCoat = false) {
    Scene scene;
    Material gloss{.metallic = 1.0f, .roughness = roughness};
    if (ofCoat) {
        gloss = {.baseColor = {0, 0, 0, 1}, .metallic = 0.0f, .roughness = 1.0f};
        gloss.specular = 0.0f;
        gloss.clearcoat = 1.0f;
        gloss.clearcoatRoughness = roughness;
    }
    gloss.reflection = Reflection::none;
    (ofCoat ? gloss.clearcoatNormalTexture : gloss.normalTexture).texture =
        addImage(scene, 256, [&](std::uint32_t x, std::uint32_t y) {
            const double u = slope * std::sin(0.63 * x + 0.2 * y), v = slope * std::sin(0.57 * y);
            return texelOf(glm::normalize(glm::dvec3(-u, -v, 1.0)));
        });
    place(scene, sheet(1.0f, addMaterial(scene, gloss)));
    addLight(scene, {.kind = LightKind::directional, .intensity = glm::vec3(ofCoat ? 50.0f : 2.0f)},
             glm::rotate(glm::dmat4(1.0), 0.25, glm::dvec3(0.6, 0.8, 0.0)));
    return scene;
}

struct Highlights {
    double brightest = 0.0, mean = 0.0;
};

// Of squares of `step` by `step` pixels.
Highlights highlightsOf(const Image& image, std::uint32_t step) {
    Highlights seen;
    const std::uint32_t edge = image.width / step;
    for (std::uint32_t y = 0; y < edge; ++y) {
        for (std::uint32_t x = 0; x < edge; ++x) {
            double sum = 0.0;
            for (std::uint32_t k = 0; k < step * step; ++k) {
                sum += double{color(image, step * x + k % step, step * y + k / step).g};
            }
            sum /= double(step) * step;
            seen.brightest = std::max(seen.brightest, sum);
            seen.mean += sum / (double(edge) * edge);
        }
    }
    return seen;
}

// Both of pictures of 64 by 64 pixels, against those of much smaller pixels.
void expectHighlightsOfSmallPixels(FrameRequest r, const char* label) {
    r.camera.yfov = 0.26;
    r.environment.map = "black";
    r.width = r.height = 64;
    const Highlights coarse = highlightsOf(renderer().render(r).image, 1);
    r.width = r.height = 1024;
    const Highlights fine = highlightsOf(renderer().render(r).image, 16);
    std::printf("%s: brightest %.2f of %.2f, mean %.4f of %.4f\n", label, coarse.brightest,
                fine.brightest, coarse.mean, fine.mean);
    EXPECT_GT(coarse.brightest, 0.6 * fine.brightest);
    EXPECT_LT(coarse.brightest, 1.6 * fine.brightest);
    EXPECT_GT(coarse.mean, 0.65 * fine.mean);
    EXPECT_LT(coarse.mean, 1.15 * fine.mean);
}

// A pixel shows the mean of the highlights of its bumps. At one point each, the brightest pixel has
// up to 190 times that light, and the picture 0.7 to 9 times.
TEST_F(NormalMaps, GlintsAreTheMeanOfTheirPixel) {
    for (const float roughness : {0.05f, 0.1f, 0.2f}) {
        for (const double slope : {0.1, 0.3}) {
            const std::string label =
                "roughness " + std::to_string(roughness) + ", slope " + std::to_string(slope);
            SCOPED_TRACE(label);
            expectHighlightsOfSmallPixels(
                request(wavedSheet(roughness, slope), "glints", {0, 0, 2}), label.c_str());
        }
    }
}

TEST_F(NormalMaps, GlintsOfACoatAreTheMeanOfTheirPixel) {
    expectHighlightsOfSmallPixels(request(wavedSheet(0.1f, 0.3, true), "coat", {0, 0, 2}),
                                  "clear coat");
}

// So do rays that meet bumps: the sheet is seen in a mirror.
TEST_F(NormalMaps, GlintsInAMirrorAreTheMeanOfTheirPixel) {
    for (const bool ofCoat : {false, true}) {
        Scene scene = wavedSheet(0.1f, 0.3, ofCoat);
        place(scene, quad(1.0f, addMaterial(scene, mirrorMetal())),
              glm::rotate(moved(0, 0, 1.0), glm::pi<double>(), glm::dvec3(0, 1, 0)));
        FrameRequest r = request(std::move(scene), "mirrored glints", {0, 0, 0.02});
        r.camera.target = glm::dvec3(0, 0, 1);
        r.accuracy.planar = PlanarMethod::traced;
        expectHighlightsOfSmallPixels(r, ofCoat ? "clear coat in a mirror" : "in a mirror");
    }
}

}  // namespace
}  // namespace clerestory::test
