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

}  // namespace
}  // namespace clerestory::test
