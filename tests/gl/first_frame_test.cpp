// Sentences about the simplest frames.
#include "support.h"

#include "image/encode.h"

#include <filesystem>
#include <fstream>

using namespace clerestory;
using namespace clerestory::test;

namespace {

class FirstFrame : public GlTest {};

Material emitter(const glm::vec3& emitted, float strength) {
    Material m;
    m.baseColor = glm::vec4(0, 0, 0, 1);
    m.metallic = 0.0f;
    m.specular = 0.0f;
    m.emissive = emitted;
    m.emissiveStrength = strength;
    return m;
}

}  // namespace

TEST_F(FirstFrame, anEmitterInTheDarkShowsExactlyItsRadiance) {
    for (const glm::vec3& emitted :
         {glm::vec3(1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, 0, 1), glm::vec3(0.5f, 0.25f, 1)}) {
        Scene scene;
        place(scene, quad(1.0f, addMaterial(scene, emitter(emitted, 10.0f))));
        const Frame frame = renderer().render(request(std::move(scene), "emitter"));
        const glm::vec3 seen = centerColor(frame.image);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(seen[c], 10.0f * emitted[c], 1e-3f) << c;
        EXPECT_EQ(color(frame.image, 1, 1), glm::vec3(0.0f));
    }
}

TEST_F(FirstFrame, aPictureComesOut) {
    Scene scene;
    const Index red =
        addMaterial(scene, {.baseColor = {0.8f, 0.1f, 0.1f, 1}, .metallic = 0, .roughness = 0.4f});
    const Index metal = addMaterial(scene, {.baseColor = {1.0f, 0.8f, 0.4f, 1}, .roughness = 0.2f});
    place(scene, sphere(0.7f, 32, red), moved(-0.8, 0, 0));
    place(scene, sphere(0.7f, 32, metal), moved(0.8, 0, 0));
    FrameRequest r = request(std::move(scene), "first");
    r.width = 640;
    r.height = 360;
    r.environment.map = "sky";
    r.output.format = OutputFormat::png;
    const Frame frame = renderer().render(r);
    std::filesystem::create_directories(CLERESTORY_TEST_OUTPUT);
    std::ofstream(std::string(CLERESTORY_TEST_OUTPUT) + "/first.png", std::ios::binary)
        << encodePng(frame.image);
    std::puts(toText(frame.plan).c_str());
}
