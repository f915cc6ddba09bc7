// Whole frames: orientation, size, camera, repetition.
#include "lit_room.h"

#include <algorithm>
#include <cmath>

using namespace clerestory;
using namespace clerestory::test;

namespace {

class Views : public GlTest {};

// Two balls before the sky, one over the other.
FrameRequest twoBalls(const glm::dvec3& shift = glm::dvec3(0.0)) {
    Scene scene;
    const Index red = addMaterial(
        scene, {.baseColor = {0.8f, 0.1f, 0.1f, 1}, .metallic = 0.0f, .roughness = 0.4f});
    const Index metal = addMaterial(scene, {.baseColor = {1, 0.8f, 0.4f, 1}, .roughness = 0.3f});
    place(scene, sphere(0.7f, 24, red), moved(shift.x, shift.y + 0.8, shift.z));
    place(scene, sphere(0.7f, 24, metal), moved(shift.x, shift.y - 0.8, shift.z));
    FrameRequest r = request(std::move(scene), "two balls", shift + glm::dvec3(0, 0, 2));
    r.environment.map = "sky";
    return r;
}

const std::uint8_t* pixel(const Image& image, std::uint32_t x, std::uint32_t y) {
    return image.bytes() + (std::size_t{y} * image.width + x) * image.channels;
}

}  // namespace

TEST_F(Views, TheTopRowComesFirst) {
    Scene scene;
    place(scene, quad(0.5f, addMaterial(scene, unlit({1, 0, 0, 1}))), moved(0, 1, 0));
    place(scene, quad(0.5f, addMaterial(scene, unlit({0, 0, 1, 1}))), moved(0, -1, 0));
    FrameRequest r = request(std::move(scene), "upright");
    const Image floats = renderer().render(r).image;
    EXPECT_EQ(color(floats, 32, 16), glm::vec3(1, 0, 0));
    EXPECT_EQ(color(floats, 32, 48), glm::vec3(0, 0, 1));
    r.output.format = OutputFormat::png;
    r.toneMap = ToneMap::linear;
    for (const bool filtered : {false, true}) {
        r.accuracy.edgeFilter = filtered;
        const Image bytes = renderer().render(r).image;
        EXPECT_EQ(pixel(bytes, 32, 16)[0], 255);
        EXPECT_EQ(pixel(bytes, 32, 16)[2], 0);
        EXPECT_EQ(pixel(bytes, 32, 48)[0], 0);
        EXPECT_EQ(pixel(bytes, 32, 48)[2], 255);
    }
}

TEST_F(Views, LeftIsLeft) {
    Scene scene;
    place(scene, quad(0.5f, addMaterial(scene, unlit({1, 0, 0, 1}))), moved(-1, 0, 0));
    const Image image = renderer().render(request(std::move(scene), "left")).image;
    EXPECT_EQ(color(image, 16, 32), glm::vec3(1, 0, 0));
    EXPECT_EQ(color(image, 48, 32), glm::vec3(0));
}

TEST_F(Views, DisplayColourIsSrgbEncoded) {
    Scene scene;
    place(scene, quad(1.0f, addMaterial(scene, unlit({0.5f, 0.2140411f, 0.0030f, 1}))));
    FrameRequest r = request(std::move(scene), "encoded");
    r.output.format = OutputFormat::png;
    r.toneMap = ToneMap::linear;
    const Image image = renderer().render(r).image;
    EXPECT_NEAR(pixel(image, 32, 32)[0], 188, 1);  // IEC 61966-2-1
    EXPECT_NEAR(pixel(image, 32, 32)[1], 128, 1);
    EXPECT_NEAR(pixel(image, 32, 32)[2], 10, 1);
}

TEST_F(Views, ExposureIsInStops) {
    Scene scene;
    place(scene, quad(1.0f, addMaterial(scene, unlit({0.25f, 0.25f, 0.25f, 1}))));
    FrameRequest r = request(std::move(scene), "exposed");
    r.output.format = OutputFormat::png;
    r.toneMap = ToneMap::linear;
    r.exposure = 1.0;
    EXPECT_NEAR(pixel(renderer().render(r).image, 32, 32)[0], 188, 1);
}

TEST_F(Views, TheSkyIsIndependentOfCameraPosition) {
    FrameRequest r = request(Scene{}, "empty");
    r.environment.map = "sky";
    const Image first = renderer().render(r).image;
    for (const glm::dvec3& place : {glm::dvec3(1000, -3, 0.1), glm::dvec3(1e8, 1e8, -1e8)}) {
        r.camera.position = place;
        r.camera.target = place - glm::dvec3(0, 0, 1);
        EXPECT_EQ(renderer().render(r).image.data, first.data);
    }
}

TEST_F(Views, TheSkyShowsTheMapInTheViewDirection) {
    // Six faces of six colours, none of which is symmetric.
    EnvironmentMap map;
    map.name = "six colours";
    map.faceSize = 4;
    const glm::vec3 faces[6] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {0, 1, 1}, {1, 0, 1}};
    for (const glm::vec3& face : faces) map.texels.insert(map.texels.end(), 16, face);
    completeMap(map);
    renderer().addEnvironment(std::make_shared<EnvironmentMap>(map));
    const glm::dvec3 directions[6] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                      {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};
    FrameRequest r = request(Scene{}, "empty");
    r.environment.map = map.name;
    r.camera.yfov = 0.5;
    for (int i = 0; i < 6; ++i) {
        r.camera.target = *r.camera.position + directions[i];
        EXPECT_EQ(centerColor(renderer().render(r).image), faces[i]) << "face " << i;
    }
    // World from map: a quarter turn about Y brings the map's +Z to the world's +X.
    r.environment.rotation = {0, std::sqrt(0.5), 0, std::sqrt(0.5)};
    r.camera.target = *r.camera.position + directions[0];
    EXPECT_EQ(centerColor(renderer().render(r).image), faces[4]);
}

TEST_F(Views, HiddenSkiesAreBlackButLight) {
    FrameRequest r = twoBalls();
    const Image shown = renderer().render(r).image;
    r.environment.visible = false;
    const Image hidden = renderer().render(r).image;
    EXPECT_EQ(color(hidden, 2, 32), glm::vec3(0));
    EXPECT_NE(color(shown, 2, 32), glm::vec3(0));
    EXPECT_EQ(color(shown, 32, 16), color(hidden, 32, 16));
}

TEST_F(Views, EqualRequestsGiveEqualImages) {
    FrameRequest r = twoBalls();
    for (const OutputFormat format : {OutputFormat::npy, OutputFormat::png}) {
        r.output.format = format;
        const Image first = renderer().render(r).image;
        EXPECT_EQ(renderer().render(r).image.data, first.data);
    }
}

TEST_F(Views, ThePrepassDoesNotChangeTheImage) {
    // Walls behind a ball, each over the whole picture, bring a depth prepass; the ball alone not.
    const auto layers = [](int walls) {
        Scene scene;
        const Index m = addMaterial(scene, {.baseColor = {0.3f, 0.6f, 0.9f, 1}, .metallic = 0.0f});
        place(scene, sphere(1.0f, 16, m));
        for (int i = 0; i < walls; ++i) place(scene, quad(20.0f, m), moved(0, 0, -2.0 - i));
        FrameRequest r = request(std::move(scene), "layers", {0, 0, 1.5});
        r.environment.map = "sky";
        return renderer().render(r);
    };
    const Frame one = layers(0), many = layers(5);
    const auto surface = [](const Frame& f) {
        return *std::find_if(f.plan.passes.begin(), f.plan.passes.end(),
                             [](const Pass& p) { return p.kind() == "surface"; });
    };
    ASSERT_TRUE(std::get<DrawScene>(surface(one).work).depthDraws.empty());
    ASSERT_FALSE(std::get<DrawScene>(surface(many).work).depthDraws.empty());
    EXPECT_EQ(color(one.image, 32, 32), color(many.image, 32, 32));
    EXPECT_EQ(color(one.image, 20, 30), color(many.image, 20, 30));
}

TEST_F(Views, SteadyFramesCreateNoObjects) {
    FrameRequest r = twoBalls();
    r.output.format = OutputFormat::png;
    r.accuracy.edgeFilter = true;
    renderer().render(r);
    const RendererCounters before = renderer().counters();
    const Frame second = renderer().render(r);
    const RendererCounters after = renderer().counters();
    EXPECT_EQ(after.texturesMade, before.texturesMade);
    EXPECT_EQ(after.framebuffersMade, before.framebuffersMade);
    EXPECT_EQ(after.programsMade, before.programsMade);
    EXPECT_EQ(after.buffersMade, before.buffersMade);
    EXPECT_EQ(after.frames, before.frames + 1);
    for (const Pass& pass : second.plan.passes) EXPECT_NE(pass.kind(), "environment");
}

TEST_F(Views, CountsMatchThePlan) {
    const FrameRequest r = twoBalls();
    const RendererCounters before = renderer().counters();
    const Frame frame = renderer().render(r);
    const RendererCounters after = renderer().counters();
    EXPECT_EQ(after.drawCalls - before.drawCalls, totals(frame.plan).draws);
    EXPECT_EQ(after.triangles - before.triangles, totals(frame.plan).triangles);
    EXPECT_EQ(frame.passTimes.size(), frame.plan.passes.size());
}

TEST_F(Views, FramesOfEverySizeAreComplete) {
    FrameRequest r = twoBalls();
    r.accuracy.edgeFilter = true;
    for (const OutputFormat format : {OutputFormat::png, OutputFormat::npy}) {
        r.output.format = format;
        for (const auto& [width, height] : {std::pair{1u, 1u},
                                            {1u, 33u},
                                            {37u, 1u},
                                            {17u, 31u},
                                            {1021u, 3u},
                                            {200u, 100u},
                                            {64u, 64u}}) {
            r.width = width;
            r.height = height;
            const Image image = renderer().render(r).image;
            EXPECT_EQ(image.width, width);
            EXPECT_EQ(image.height, height);
            const std::size_t channel = format == OutputFormat::png ? 1 : sizeof(float);
            EXPECT_EQ(image.data.size(), std::size_t{width} * height * image.channels * channel);
        }
    }
}

TEST_F(Views, DistanceFromTheOriginChangesNothing) {
    const Image here = renderer().render(twoBalls()).image;
    const Image there = renderer().render(twoBalls({1e6, -2e6, 3e6})).image;
    double worst = 0.0;
    std::size_t off = 0;
    for (std::uint32_t y = 0; y < here.height; ++y) {
        for (std::uint32_t x = 0; x < here.width; ++x) {
            const glm::vec3 d = glm::abs(color(here, x, y) - color(there, x, y));
            const double greatest = std::max({d.x, d.y, d.z});
            if (greatest > 1e-4) ++off;
            worst = std::max(worst, greatest);
        }
    }
    EXPECT_LE(off, 4u) << "worst " << worst;  // a silhouette's pixel may fall to the other side
}

TEST_F(Views, SeveralSamplesSmoothEdgesOnly) {
    Scene scene;
    glm::dmat4 turned = moved(0, 0, 0);
    turned[0] = {std::cos(0.3), std::sin(0.3), 0, 0};
    turned[1] = {-std::sin(0.3), std::cos(0.3), 0, 0};
    place(scene, quad(1.0f, addMaterial(scene, unlit({1, 1, 1, 1}))), turned);
    FrameRequest r = request(std::move(scene), "edges");
    const auto between = [&](std::uint32_t samples) {
        r.accuracy.samples = samples;
        const Image image = renderer().render(r).image;
        EXPECT_EQ(centerColor(image), glm::vec3(1));
        EXPECT_EQ(color(image, 0, 0), glm::vec3(0));
        std::size_t count = 0;
        for (std::uint32_t y = 0; y < 64; ++y) {
            for (std::uint32_t x = 0; x < 64; ++x) {
                const float v = color(image, x, y).x;
                count += v > 0.0f && v < 1.0f;
            }
        }
        return count;
    };
    EXPECT_EQ(between(1), 0u);
    EXPECT_GT(between(4), 60u);  // four edges of 32 pixels and more
}

TEST_F(Views, TheEdgeFilterSmoothsEdgesOnly) {
    Scene scene;
    glm::dmat4 turned(1.0);
    turned[0] = {std::cos(0.3), std::sin(0.3), 0, 0};
    turned[1] = {-std::sin(0.3), std::cos(0.3), 0, 0};
    place(scene, quad(1.0f, addMaterial(scene, unlit({1, 1, 1, 1}))), turned);
    FrameRequest r = request(std::move(scene), "filtered edges");
    r.output.format = OutputFormat::png;
    r.toneMap = ToneMap::linear;
    const Image plain = renderer().render(r).image;
    r.accuracy.edgeFilter = true;
    const Image filtered = renderer().render(r).image;
    std::size_t changed = 0, between = 0;
    for (std::uint32_t y = 1; y < 63; ++y) {
        for (std::uint32_t x = 1; x < 63; ++x) {
            const int before = pixel(plain, x, y)[0], after = pixel(filtered, x, y)[0];
            changed += before != after;
            between += after > 0 && after < 255;
            bool edge = false;
            for (std::uint32_t n = 0; n < 9; ++n) {
                edge |= pixel(plain, x - 1 + n % 3, y - 1 + n / 3)[0] != before;
            }
            EXPECT_TRUE(edge || before == after) << x << " " << y;
        }
    }
    EXPECT_GT(between, 60u);
    EXPECT_EQ(changed, between);
}

TEST_F(Views, UnknownScenesAndMapsAreNamed) {
    FrameRequest r = twoBalls();
    r.environment.map = "moon";
    try {
        renderer().render(r);
        FAIL();
    } catch (const InvalidRequest& e) {
        ASSERT_EQ(e.errors().size(), 1u);
        EXPECT_EQ(e.errors()[0].pointer, "/environment/map");
        EXPECT_NE(e.errors()[0].allowed.find("sky"), std::string::npos);
    }
    r.scene = "nowhere";
    try {
        renderer().plan(r);
        FAIL();
    } catch (const InvalidRequest& e) {
        EXPECT_EQ(e.errors()[0].pointer, "/scene");
        EXPECT_NE(e.errors()[0].allowed.find("two balls"), std::string::npos);
    }
}

TEST_F(Views, WarmUpCompilesEveryProgram) {
    FrameRequest r = twoBalls();
    r.scene = "two balls";
    r.output.format = OutputFormat::png;
    r.accuracy.edgeFilter = true;
    WarmUp warmUp = renderer().beginWarmUp({r});
    while (renderer().advance(warmUp)) {
    }
    const RendererCounters before = renderer().counters();
    renderer().render(r);
    EXPECT_EQ(renderer().counters().programsMade, before.programsMade);
    EXPECT_EQ(renderer().counters().pipelinesMade, before.pipelinesMade);
}

// Its maps are small and have no keys; a ray from a pixel that it draws reads them.
TEST_F(Views, WarmUpFollowsRaysToShadows) {
    Scene scene;
    placeRoom(scene, addMaterial(scene, lambert(0.5f)));
    place(scene, sphere(0.5f, 32, addMaterial(scene, mirrorMetal(0.9f))));
    addLight(scene, {.intensity = glm::vec3(2.0f)}, moved(0.0, 0.8, 0.5));
    FrameRequest r = request(std::move(scene), "mirror that fills the view", {0.0, 0.0, 0.6});
    r.effects.shadows = true;
    r.accuracy.curved = CurvedMethod::traced;
    WarmUp warmUp = renderer().beginWarmUp({r});
    while (renderer().advance(warmUp)) {
    }
    const Image image = renderer().render(r).image;
    const glm::vec3 corner = color(image, 0, image.height - 1);
    EXPECT_GT(corner.x, 0.0f) << "there is a ray in the first pixel";
    EXPECT_TRUE(std::isfinite(corner.x));
}

// Each of its passes runs alone.
TEST_F(Views, AWarmUpKeepsTheTargetsOfTheLastFrame) {
    FrameRequest shown = twoBalls();
    shown.scene = "two balls";
    shown.width = 200;
    Scene scene;
    for (const float roughness : {0.0f, 0.3f, 0.9f}) {
        place(scene, sphere(0.4f, 16, addMaterial(scene, mirrorMetal(0.9f, roughness))),
              moved(roughness, 0.0, 0.0));
    }
    addLight(scene, {.intensity = glm::vec3(2.0f)}, moved(0.0, 2.0, 0.0));
    FrameRequest next = request(std::move(scene), "warmed up", {0.0, 0.0, 3.0});
    next.effects.shadows = true;
    renderer().render(shown);
    // More passes than the frames after which unused targets are deleted.
    for (int passes = 0; passes < 20;) {
        WarmUp warmUp = renderer().beginWarmUp({next});
        const int until = passes;
        while (renderer().advance(warmUp)) ++passes;
        ASSERT_GT(passes, until);
    }
    const std::uint64_t before = renderer().counters().texturesMade;
    renderer().render(shown);
    EXPECT_EQ(renderer().counters().texturesMade, before);
}

TEST_F(Views, ReplacedScenesShowImmediately) {
    for (const glm::vec3& c : {glm::vec3(1, 0, 0), glm::vec3(0, 1, 0)}) {
        Scene scene;
        place(scene, quad(1.0f, addMaterial(scene, unlit(glm::vec4(c, 1)))));
        EXPECT_EQ(centerColor(renderer().render(request(std::move(scene), "replaced")).image), c);
    }
}
