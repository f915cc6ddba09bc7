#include "prices.h"

#include "plan/cost/cost.h"
#include "scene/builtin/modelling.h"
#include "scenes.h"

#include <functional>

namespace clerestory::bench {
namespace {

// A scene with one object in front of the camera, which looks along -Z from the origin.
class Stage {
public:
    explicit Stage(const char* id) {
        scene_.id = id;
        scene_.defaultView = DefaultView{.position = {0, 0, 0}, .target = {0, 0, -1}, .yfov = 1.0};
    }
    Material& material(const char* name) {
        scene_.materials.push_back({.name = name, .metallic = 0.0f, .roughness = 0.5f});
        return scene_.materials.back();
    }
    // A wall that fills the picture, with the last material.
    void addWall(float distance = 4.0f) {
        MeshDraft mesh = shapes::draft("wall", last());
        const float r = 4.0f * distance;
        shapes::addPatch(mesh, {-r, -r, -distance}, {2 * r, 0, 0}, {0, 2 * r, 0});
        shapes::addToScene(scene_, std::move(mesh));
    }
    void addFloor() {
        MeshDraft mesh = shapes::draft("floor", last());
        shapes::addPatch(mesh, {-20, -1, 2}, {40, 0, 0}, {0, 0, -40});
        shapes::addToScene(scene_, std::move(mesh));
    }
    void addBall(float radius, int segments) {
        MeshDraft mesh = shapes::draft("ball", last());
        shapes::addSphere(mesh, {0, 0, -4}, radius, segments);
        shapes::addToScene(scene_, std::move(mesh));
    }
    void addLights(int count) {
        for (int i = 0; i < count; ++i) {
            const Index node = addNode(scene_, "light " + std::to_string(i),
                                       glm::translate(glm::dmat4(1.0), {i - 1.0, 1.0, -1.0}));
            scene_.lights.push_back({.node = node, .intensity = glm::vec3(3.0f)});
        }
    }
    Index addTexture(ColorSpace space) {
        return textures::add(scene_, "texture", 256, 256, space, [](float u, float v) {
            const float n = textures::noise(u, v, 8, 4, 1);
            return glm::vec4(0.5f + 0.1f * n, 0.5f, 1.0f, 1.0f);
        });
    }
    Scene take() { return std::move(scene_); }

private:
    Index last() const { return static_cast<Index>(scene_.materials.size() - 1); }
    Scene scene_;
};

FrameRequest frameOf(const Scene& scene, std::uint32_t width, std::uint32_t height) {
    FrameRequest request = turned(scene.id, *scene.defaultView, 0.0);
    request.width = width;
    request.height = height;
    request.accuracy.edgeFilter = false;
    request.accuracy.planar = PlanarMethod::environment;
    request.accuracy.curved = CurvedMethod::environment;
    request.accuracy.glass = GlassMethod::environment;
    return request;
}

class Measurement {
public:
    Measurement(Computation rays, int rounds)
        : renderer_(RendererOptions{.rays = rays}), rounds_(rounds) {}

    const Renderer& renderer() const { return renderer_; }

    // Milliseconds of the passes of these kinds, together, in the fastest of several frames.
    double of(Scene scene, const FrameRequest& shape, std::initializer_list<const char*> kinds) {
        const std::string id = scene.id;
        renderer_.addScene(std::move(scene));
        double best = 1e9;
        for (int i = -2; i < rounds_; ++i) {
            FrameRequest request = shape;
            // A captured cube shows the light of the environment, so each frame draws it again.
            // Light between surfaces would be computed again.
            if (!shape.effects.indirectLight) request.environment.intensity = 1.0 + 1e-4 * (i + 3);
            if (shape.effects.indirectLight && i == -2) renderer_.completeLight(request);
            const Frame frame = renderer_.render(request);
            double sum = 0.0;
            for (const PassTime& pass : frame.passTimes) {
                const bool counts = std::find(kinds.begin(), kinds.end(), pass.kind) != kinds.end();
                if (counts) sum += pass.milliseconds;
            }
            if (i >= 0) best = std::min(best, sum);
        }
        renderer_.removeScene(id);
        return best;
    }

private:
    Renderer renderer_;
    int rounds_;
};

constexpr std::uint32_t kWidth = 1280, kHeight = 720;
constexpr double kPixels = double(kWidth) * kHeight;

// Milliseconds per pixel of a wall with this material and these lights.
double pixelPrice(Measurement& measure, int lights,
                  const std::function<void(Stage&, Material&)>& finish, Shading shading = {}) {
    const auto at = [&](std::uint32_t width, std::uint32_t height) {
        Stage stage("wall");
        finish(stage, stage.material("wall"));
        stage.addWall();
        if (shading.shadows || shading.surfaceLight) stage.addBall(0.2f, 8);
        stage.addLights(lights);
        Scene scene = stage.take();
        FrameRequest request = frameOf(scene, width, height);
        request.effects.shadows = shading.shadows;
        request.effects.indirectLight = shading.surfaceLight;
        return measure.of(std::move(scene), request, {"surface"});
    };
    return (at(kWidth, kHeight) - at(16, 9)) / (kPixels - 16 * 9);
}

void addShading(Measurement& measure, std::vector<Price>& prices, const Prices& model) {
    const auto plain = [](Stage&, Material&) {};
    const auto textured = [](Stage& stage, Material& m) {
        m.baseColorTexture.texture = stage.addTexture(ColorSpace::srgb);
        m.metallicRoughnessTexture.texture = stage.addTexture(ColorSpace::linear);
        m.normalTexture.texture = stage.addTexture(ColorSpace::linear);
    };
    const auto glass = [](Stage&, Material& m) {
        m.transmission = 1.0f;
        m.roughness = 0.0f;
    };
    const auto add = [&](const char* name, double measured, double compiledIn) {
        prices.push_back({name, 1e6 * measured, 1e6 * compiledIn, "ns"});
    };
    const double bare = pixelPrice(measure, 0, plain), lit = pixelPrice(measure, 4, plain);
    add("pixel, no light", bare, model.pixel);
    add("each of 4 lights", (lit - bare) / 4.0, model.pixelLight);
    add("each of 4 shadows", (pixelPrice(measure, 4, plain, {.shadows = true}) - lit) / 4.0,
        model.pixelShadow);
    add("light between surfaces", pixelPrice(measure, 4, plain, {.surfaceLight = true}) - lit,
        model.pixelSurfaceLight);
    add("each of 3 textures", (pixelPrice(measure, 0, textured) - bare) / 3.0, model.pixelTexture);
    add("pixel, 3 textures, 4 lights", pixelPrice(measure, 4, textured),
        model.pixel + 4.0 * model.pixelLight + 3.0 * model.pixelTexture);
    add("pixel of glass over the environment", pixelPrice(measure, 0, glass), 0.0);
}

void addViews(Measurement& measure, std::vector<Price>& prices, const Prices& model) {
    const auto balls = [&](int segments, std::uint32_t width, std::uint32_t height,
                           std::uint64_t& triangles) {
        Stage stage("ball");
        stage.material("ball");
        stage.addBall(1.5f, segments);
        Scene scene = stage.take();
        triangles = scene.indices.size() / 3;
        const FrameRequest request = frameOf(scene, width, height);
        return measure.of(std::move(scene), request, {"surface"});
    };
    std::uint64_t few = 0, many = 0;
    const double small = balls(16, 64, 36, few), large = balls(400, 64, 36, many);
    prices.push_back(
        {"triangle", 1e6 * (large - small) / double(many - few), 1e6 * model.triangle, "ns"});

    Stage stage("mirror");
    Material& mirror = stage.material("mirror");
    mirror.metallic = 1.0f;
    mirror.roughness = 0.0f;
    stage.addFloor();
    stage.material("ball");
    stage.addBall(0.5f, 16);
    Scene scene = stage.take();
    FrameRequest request = frameOf(scene, 64, 36);
    request.accuracy.planar = PlanarMethod::mirror;
    prices.push_back({"view", measure.of(std::move(scene), request, {"mirror"}), model.view, "ms"});
}

void addCopies(Measurement& measure, std::vector<Price>& prices, const Prices& model) {
    Stage stage("glass");
    Material& glass = stage.material("glass");
    glass.transmission = 1.0f;
    glass.roughness = 0.0f;
    stage.addWall();
    Scene scene = stage.take();
    FrameRequest request = frameOf(scene, kWidth, kHeight);
    request.accuracy.glass = GlassMethod::backdrop;
    prices.push_back({"copied pixel",
                      1e6 * measure.of(std::move(scene), request, {"backdrop"}) / kPixels,
                      1e6 * model.copiedPixel, "ns"});
}

// A cube that is captured around a ball of metal: its prefiltering per texel and direction.
void addCubes(Measurement& measure, std::vector<Price>& prices, const Prices& model) {
    Stage stage("cube");
    stage.material("wall");
    stage.addWall(8.0f);
    Material& metal = stage.material("ball");
    metal.metallic = 1.0f;
    metal.roughness = 0.0f;
    stage.addBall(1.0f, 32);
    Scene scene = stage.take();
    FrameRequest request = frameOf(scene, 64, 36);
    request.accuracy.curved = CurvedMethod::probe;
    request.accuracy.generations = 1;
    const double samples = 8.0 * 256 * 256 * request.accuracy.probeSamples;
    prices.push_back({"sample of a prefiltered cube",
                      1e6 * measure.of(std::move(scene), request, {"prefilter"}) / samples,
                      1e6 * model.mapSample, "ns"});
}

// A ball of metal or glass in front of a wall.
void addRays(Measurement& measure, std::vector<Price>& prices, const Prices& model,
             const std::string& where) {
    const auto at = [&](bool glass, float radius, std::uint32_t bounces, int lights = 0) {
        Stage stage("rays");
        stage.addLights(lights);
        stage.material("wall");
        stage.addWall(8.0f);
        Material& m = stage.material("ball");
        m.metallic = glass ? 0.0f : 1.0f;
        m.transmission = glass ? 1.0f : 0.0f;
        m.thickness = glass ? radius : 0.0f;
        m.roughness = 0.0f;
        stage.addBall(radius, 48);
        Scene scene = stage.take();
        FrameRequest request = frameOf(scene, kWidth, kHeight);
        request.accuracy.bounces = bounces;
        const double without = measure.of(scene, request, {"surface", "glass", "backdrop", "rays"});
        if (glass) request.accuracy.glass = GlassMethod::traced;
        if (!glass) request.accuracy.curved = CurvedMethod::traced;
        return measure.of(std::move(scene), request, {"surface", "glass", "backdrop", "rays"}) -
               without;
    };
    const auto pixels = [](double radius) {  // of the ball's outline
        const double slope = radius / std::sqrt(16.0 - radius * radius);
        const double perSlope = 0.5 * kHeight / std::tan(0.5);
        return 3.14159265 * slope * slope * perSlope * perSlope;
    };
    const double small = at(false, 0.2f, 4), large = at(false, 1.6f, 4);
    const double pixel = (large - small) / (pixels(1.6) - pixels(0.2));
    prices.push_back(
        {"rays, " + where, small - pixel * pixels(0.2), model.rayPass + model.raySurface, "ms"});
    prices.push_back({"pixel with a ray, " + where, 1e6 * pixel, 1e6 * model.rayPixel, "ns"});
    prices.push_back({"light at a hit, " + where,
                      1e6 * (at(false, 1.6f, 4, 4) - large) / 4.0 / pixels(1.6),
                      1e6 * model.rayLight, "ns"});
    const double segment = (at(true, 1.6f, 4) - at(true, 1.6f, 1)) / pixels(1.6) /
                           (glassRaySegments(4) - glassRaySegments(1));
    prices.push_back({"further segment, " + where, 1e6 * segment, 1e6 * model.raySegment, "ns"});
}

}  // namespace

std::vector<Price> measurePrices(int rounds) {
    std::vector<Price> prices;
    Measurement measure(Computation::automatic, rounds);
    const bool software = measure.renderer().identity().software;
    const Prices& model = pricesOf(software, software);
    addShading(measure, prices, model);
    addViews(measure, prices, model);
    addCopies(measure, prices, model);
    addCubes(measure, prices, model);
    Measurement processor(Computation::processor, rounds), shader(Computation::shader, rounds);
    addRays(processor, prices, pricesOf(software, true), "processor");
    addRays(shader, prices, pricesOf(software, false), "shader");
    return prices;
}

}  // namespace clerestory::bench
