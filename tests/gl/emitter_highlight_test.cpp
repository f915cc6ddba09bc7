// Highlights of emissive surfaces on rough ones.
#include "lit_room.h"
#include "reference/reference.h"

#include <cmath>
#include <numbers>

using namespace clerestory;
using namespace clerestory::test;

namespace {

class HighlightsOfEmitters : public GlTest {};

}  // namespace

// Emissive surfaces have highlights. A small one is a lamp: from its direction, at a distance of a
// metre and a half, both look the same on rough metal and on a rough dielectric.
TEST_F(HighlightsOfEmitters, SmallOnesAreThoseOfLamps) {
    constexpr double kHalf = 0.05, kRadiance = 200.0;
    const auto seen = [&](const Material& material, bool emitter, double elevation) {
        Scene scene;
        place(scene, quad(3.0f, addMaterial(scene, material)), facingUp());
        const glm::dvec3 at(-1.5 * std::cos(elevation), 1.5 * std::sin(elevation), 0.0);
        glm::dmat4 frame = moved(at.x, at.y, at.z);
        frame = frame * glm::rotate(glm::dmat4(1.0), elevation, glm::dvec3(0.0, 0.0, -1.0)) *
                glm::rotate(glm::dmat4(1.0), 0.5 * std::numbers::pi, glm::dvec3(0.0, 1.0, 0.0));
        if (emitter) {
            place(scene, quad(kHalf, addMaterial(scene, lambert(0.0f, kRadiance))), frame);
        } else {
            addLight(scene, {.intensity = glm::vec3(4.0 * kHalf * kHalf * kRadiance)}, frame);
        }
        FrameRequest r = lookingAt(request(std::move(scene), "highlight"),
                                   {2.0 * std::cos(0.7), 2.0 * std::sin(0.7), 0.0}, {});
        if (emitter) r = lit(r);
        return static_cast<double>(centerColor(renderer().render(r).image).x);
    };
    const Material metal{.baseColor = glm::vec4(0.9f, 0.9f, 0.9f, 1.0f), .roughness = 0.6f};
    const Material dielectric{
        .baseColor = glm::vec4(0.1f, 0.1f, 0.1f, 1.0f), .metallic = 0.0f, .roughness = 0.4f};
    for (const Material& material : {metal, dielectric}) {
        for (const double elevation : {0.4, 0.7, 1.0}) {
            const double lamp = seen(material, false, elevation);
            EXPECT_NEAR(seen(material, true, elevation) / lamp, 1.0, 0.05)
                << material.metallic << ' ' << elevation;
        }
    }
}

// A larger one has a wider highlight, as the path tracer has it.
TEST_F(HighlightsOfEmitters, LargeOnesAreThoseOfTheReference) {
    Scene scene;
    place(scene,
          quad(3.0f, addMaterial(scene, {.baseColor = glm::vec4(0.9f, 0.9f, 0.9f, 1.0f),
                                         .roughness = 0.55f})),
          facingUp());
    place(scene, quad(0.4f, addMaterial(scene, lambert(0.0f, 4.0f))), facingDown(1.2));
    const EnvironmentMap black = constantEnvironment("black", glm::vec3(0.0f));
    for (const double x : {0.0, 0.25, 0.5, 1.0, 1.5}) {
        FrameRequest r = request(Scene(scene), "large");
        r.camera.position = {x + 1.0, 0.9, 0.0};
        r.camera.target = {x, 0.0, 0.0};
        r.camera.yfov = 0.02;
        r.width = r.height = 5;
        r = lit(r);
        const auto truth = traceReference({.scene = scene,
                                           .frame = r,
                                           .environment = black,
                                           .mode = ReferenceMode::full,
                                           .samples = 512});
        EXPECT_NEAR(centerColor(renderer().render(r).image).x / truth->color.floats()[3 * 12], 1.0,
                    0.15)
            << x;
    }
}
