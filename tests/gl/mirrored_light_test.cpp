// Light that flat mirrors throw onto other surfaces, by the method of images.
#include "lit_room.h"

#include <cmath>
#include <numbers>

using namespace clerestory;
using namespace clerestory::test;

namespace {

class LightOfMirrors : public GlTest {};

}  // namespace

// The method of images: next to a wide mirror a floor has the light of the lamp and of its image.
TEST_F(LightOfMirrors, AFlatMirrorThrowsTheLightOfALamp) {
    constexpr double kTint = 0.9;
    const auto seen = [&](bool mirror, bool shade) {
        Scene scene;
        place(scene, quad(3.0f, addMaterial(scene, lambert(0.1f))), facingUp());
        addLight(scene, {.intensity = glm::vec3(20.0f)}, moved(0.0, 1.0, 0.0));
        if (mirror) {
            const Index silver = addMaterial(scene, {.baseColor = glm::vec4(glm::vec3(kTint), 1.0f),
                                                     .metallic = 1.0f,
                                                     .roughness = 0.0f,
                                                     .doubleSided = true});
            place(scene, quad(0.45f, silver),
                  moved(1.0, 0.5, 0.0) * glm::rotate(glm::dmat4(1.0), 0.5 * std::numbers::pi,
                                                     glm::dvec3(0.0, 1.0, 0.0)));
        }
        if (shade) {
            Material black = lambert(0.0f);
            black.doubleSided = true;
            place(scene, quad(0.2f, addMaterial(scene, black)),
                  moved(0.5, 0.8, 0.0) * glm::rotate(glm::dmat4(1.0), 0.5 * std::numbers::pi,
                                                     glm::dvec3(0.0, 1.0, 0.0)));
        }
        FrameRequest r = request(std::move(scene), "mirror");
        r = lookingAt(r, {0.0, 0.8, 2.0}, {0.0, 0.0, 0.0});
        if (mirror) r = lit(r);
        return static_cast<double>(centerColor(renderer().render(r).image).x);
    };
    const double lamp = 0.1 * 20.0 / std::numbers::pi, root = std::sqrt(5.0);
    const double reflected = kTint + (1.0 - kTint) * std::pow(1.0 - 2.0 / root, 5.0);
    const double thrown = lamp * reflected / (5.0 * root);
    const double direct = seen(false, false);
    EXPECT_NEAR(direct, lamp, 0.02 * lamp);
    EXPECT_NEAR(seen(true, false) - direct, thrown, 0.06 * thrown);
    EXPECT_LT(seen(true, true) - direct, 0.06 * thrown);
}

// A large perfect mirror shows the other half of the world: the floor in front of it has the sky
// that the mirror hides and the light of a second lamp behind it.
TEST_F(LightOfMirrors, AWideMirrorDoublesTheWorld) {
    const auto seen = [&](bool mirror, bool lamps, bool sky) {
        Scene scene;
        place(scene, quad(8.0f, addMaterial(scene, lambert(0.5f))), facingUp());
        Material glows = lambert(0.0f, 4.0f);
        const Index lamp = addMaterial(scene, glows);
        if (lamps) place(scene, quad(0.25f, lamp), facingDown(1.0));
        if (mirror) {
            const Index silver = addMaterial(scene, {.metallic = 1.0f, .roughness = 0.0f});
            place(scene, quad(8.0f, silver),
                  moved(0.5, 8.0, 0.0) * glm::rotate(glm::dmat4(1.0), -0.5 * std::numbers::pi,
                                                     glm::dvec3(0.0, 1.0, 0.0)));
        } else if (lamps) {
            place(scene, quad(0.25f, lamp), moved(1.0, 0.0, 0.0) * facingDown(1.0));
        }
        FrameRequest r = request(std::move(scene), "wide");
        if (sky) r.environment.map = "white";
        r = lookingAt(r, {0.0, 0.3, 2.0}, {0.0, 0.0, 0.0});
        if (mirror || lamps) r = lit(r);
        return static_cast<double>(centerColor(renderer().render(r).image).x);
    };
    for (const bool lamps : {false, true}) {
        const double images = seen(false, lamps, !lamps);
        EXPECT_NEAR(seen(true, lamps, !lamps) / images, 1.0, 0.05) << lamps;
    }
}
