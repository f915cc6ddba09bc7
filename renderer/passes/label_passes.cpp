// Passes that derive labels from drawn identifiers, on the processor.
#include "image/bands.h"
#include "passes/instance_counts.h"
#include "passes/layer_flow.h"
#include "passes/passes.h"
#include "passes/processor_tracer.h"
#include "scene/surface_point.h"

#include <algorithm>
#include <memory>
#include <mutex>

namespace clerestory {
namespace {

// Calls act(pixel, drawn) for each pixel with a surface, from several threads. Pixels are counted
// from the upper left corner; `drawn` identifies the surface.
template <class Act>
void forEachDrawn(const PassInput& input, TargetId surfaces, const Act& act) {
    const gl::Framebuffer& source = input.read(surfaces).readable();
    const std::uint32_t width = source.width(), height = source.height();
    std::vector<float> drawn(std::size_t{4} * width * height);
    source.readFloats(drawn);
    forEachBand(height, 8, [&](std::uint32_t first, std::uint32_t end) {
        for (std::uint32_t y = first; y < end; ++y) {
            // OpenGL's first row is the bottom one.
            const float* in = drawn.data() + std::size_t{4} * width * (height - 1 - y);
            for (std::uint32_t x = 0; x < width; ++x, in += 4) {
                if (in[0] >= 1.0f) act(glm::uvec2(x, y), in);
            }
        }
    });
}

glm::dvec2 centreOf(const glm::uvec2& pixel) {
    return glm::dvec2(pixel) + 0.5;
}

// Calls act(centre of the pixel, drawn, out) likewise: `out` are the pixel's numbers in the target.
template <class Act>
void forEachPixel(const PassInput& input, TargetId surfaces, std::uint32_t channels,
                  const Act& act) {
    const gl::Framebuffer& source = input.read(surfaces).readable();
    const std::uint32_t width = source.width();
    Image& image = input.target().picture().image;
    reshape(image, width, source.height(), channels, PixelType::float32);
    std::fill(image.data.begin(), image.data.end(), std::byte{0});
    forEachDrawn(input, surfaces, [&](const glm::uvec2& pixel, const float* drawn) {
        act(centreOf(pixel), drawn,
            image.floats() + channels * (std::size_t{width} * pixel.y + pixel.x));
    });
}

const SurfaceDraw& drawOf(std::span<const SurfaceDraw> draws, const float* drawn) {
    return draws[static_cast<std::size_t>(drawn[0]) - 1];
}

SurfacePoint surfaceAt(const PassInput& input, const SurfaceDraw& draw, const float* drawn,
                       const PixelRay& ray) {
    const Scene& scene = input.scene->scene();
    const Primitive kind = scene.meshes[scene.instances[draw.instance].mesh].primitive;
    const std::uint32_t first =
        draw.firstIndex + indicesPer(kind) * static_cast<std::uint32_t>(drawn[1]);
    return pointAlong(scene, input.pose, draw.instance, first, ray.origin, ray.direction);
}

void put(const glm::dvec3& value, float* out) {
    for (int i = 0; i < 3; ++i) out[i] = static_cast<float>(value[i]);
}

// Begins rays in the scene of the frame at a pose, which `tracer` has.
LayerRays layerRays(PassResources& resources, const PassInput& input, ProcessorTracer& tracer,
                    const Pose& pose, const View& view) {
    const Scene& scene = input.scene->scene();
    resources.draws.begin(scene, pose, view, glm::dmat3(1.0), input.plan.lights);
    return {scene, pose, input.plan, tracer.beginLookups(input.plan, resources.draws),
            tracer.origin()};
}

// The ray of a pixel that shows a mirror or glass; none where the layer is empty.
std::optional<LayerRays::PixelView> pixelView(const PassInput& input, const LayerRays& layers,
                                              OutputLayer layer, const Projection& from,
                                              const SurfaceDraw& draw, const float* drawn,
                                              const glm::dvec2& pixel) {
    const bool glass = layers.glassOf(draw.instance) != Glass::none;
    if (!glass && !(layer == OutputLayer::reflected && draw.mirrors)) return std::nullopt;
    const auto ray = rayThrough(from, pixel);
    if (!ray) return std::nullopt;
    return LayerRays::PixelView{*ray, surfaceAt(input, draw, drawn, *ray),
                                spreadAt(from, pixel, *ray)};
}

// The channel's value for the surface that a ray hits.
void putLayer(const FramePlan& plan, const FollowLayer& work, const PixelRay& ray,
              const LayerRays::Met& met, float* out) {
    const Index instance = met.point.instance;
    switch (plan.channel) {
        case Channel::depth:
            *out = static_cast<float>(met.length *
                                      depthPerDistance(work.from, glm::normalize(ray.direction)));
            break;
        case Channel::normal:
            put(met.normal, out);
            break;
        case Channel::position:
            put(met.position, out);
            break;
        case Channel::albedo:
            put(met.baseColor, out);
            break;
        default:
            *out = static_cast<float>(work.labels.empty() ? instance + 1 : work.labels[instance]);
    }
}

void measureDirectFlow(const PassInput& input, const MeasureFlow& work) {
    const Scene& scene = input.scene->scene();
    forEachPixel(
        input, work.source, 3, [&](const glm::dvec2& pixel, const float* drawn, float* out) {
            const auto ray = rayThrough(work.from, pixel);
            if (!ray) return;
            const SurfacePoint seen = surfaceAt(input, drawOf(work.draws, drawn), drawn, *ray);
            // Both points are projected, so that static surfaces have a flow of exactly 0.
            const auto from = projected(work.from, positionOf(scene, input.pose, seen));
            const auto to = projected(work.to, positionOf(scene, *input.flowPose, seen));
            if (!from || !to) return;
            put({displacement(work.to, from->pixel, to->pixel), to->depth}, out);
        });
}

// The search begins where the point of the mirror or glass moves, so that what is at rest has a
// flow of exactly 0.
void measureLayerFlow(PassResources& resources, const PassInput& input, const MeasureFlow& work) {
    const Scene& scene = input.scene->scene();
    const LayerRays layers =
        layerRays(resources, input, *input.processorTracer, input.pose, work.from.view);
    std::unique_ptr<const LayerRays> there;
    if (input.flowTracer) {
        there.reset(new LayerRays(
            layerRays(resources, input, *input.flowTracer, *input.flowPose, work.to.view)));
    }
    const FlowTarget target{work.to, there ? *there : layers, work.layer};
    forEachPixel(
        input, work.source, 3, [&](const glm::dvec2& pixel, const float* drawn, float* out) {
            const auto view = pixelView(input, layers, work.layer, work.from,
                                        drawOf(work.draws, drawn), drawn, pixel);
            if (!view) return;
            const auto shown = layers.shown(work.layer, *view);
            if (!shown) return;
            const auto from = projected(work.from, positionOf(scene, input.pose, view->seen));
            const auto moved = projected(work.to, positionOf(scene, *input.flowPose, view->seen));
            if (!from || !moved) return;
            const glm::dvec2 start = pixel + displacement(work.to, from->pixel, moved->pixel);
            const auto to = shownAt(target, {view->seen, shown->faces},
                                    positionOf(scene, *input.flowPose, shown->met.point), start);
            if (to) put({displacement(work.to, pixel, to->pixel), to->depth}, out);
        });
}

}  // namespace

void execute(PassResources& resources, const PassInput& input, const MeasureFlow& work) {
    if (work.layer == OutputLayer::direct)
        measureDirectFlow(input, work);
    else
        measureLayerFlow(resources, input, work);
}

void execute(PassResources& resources, const PassInput& input, const FollowLayer& work) {
    const LayerRays layers =
        layerRays(resources, input, *input.processorTracer, input.pose, work.from.view);
    forEachPixel(input, work.source, channelsOf(input.plan.channel),
                 [&](const glm::dvec2& pixel, const float* drawn, float* out) {
                     const auto view = pixelView(input, layers, work.layer, work.from,
                                                 drawOf(work.draws, drawn), drawn, pixel);
                     if (!view) return;
                     const auto shown = layers.shown(work.layer, *view);
                     if (shown) putLayer(input.plan, work, view->ray, shown->met, out);
                 });
}

void execute(PassResources& resources, const PassInput& input, const CountLayer& work) {
    const LayerRays layers =
        layerRays(resources, input, *input.processorTracer, input.pose, work.from.view);
    std::mutex mutex;
    LayerCounts counts;
    forEachDrawn(input, work.source, [&](const glm::uvec2& pixel, const float* drawn) {
        const auto view = pixelView(input, layers, work.layer, work.from, drawOf(work.draws, drawn),
                                    drawn, centreOf(pixel));
        if (!view) return;
        std::vector<Index> instances;
        layers.instancesAlong(work.layer, *view, instances);
        const std::lock_guard lock(mutex);
        counts.add(instances, pixel.x, pixel.y);
    });
    resources.instances = counts.all();
}

}  // namespace clerestory
