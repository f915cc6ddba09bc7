// Passes that derive labels from drawn identifiers, on the processor.
#include "image/bands.h"
#include "passes/layer_rays.h"
#include "passes/passes.h"
#include "passes/processor_tracer.h"
#include "scene/surface_point.h"

#include <algorithm>

namespace clerestory {
namespace {

// Calls act(pixel, drawn, out) for each pixel, from several threads: `drawn` identifies its surface
// and `out` are its numbers in the target.
template <class Act>
void forEachPixel(const PassInput& input, TargetId surfaces, std::uint32_t channels,
                  const Act& act) {
    const gl::Framebuffer& source = input.read(surfaces).readable();
    const std::uint32_t width = source.width(), height = source.height();
    std::vector<float> drawn(std::size_t{4} * width * height);
    source.readFloats(drawn);
    Image& image = input.target().picture().image;
    reshape(image, width, height, channels, PixelType::float32);
    std::fill(image.data.begin(), image.data.end(), std::byte{0});
    forEachBand(height, 8, [&](std::uint32_t first, std::uint32_t end) {
        for (std::uint32_t y = first; y < end; ++y) {
            // OpenGL's first row is the bottom one.
            const float* in = drawn.data() + std::size_t{4} * width * (height - 1 - y);
            float* out = image.floats() + std::size_t{channels} * width * y;
            for (std::uint32_t x = 0; x < width; ++x, in += 4, out += channels) {
                if (in[0] >= 1.0f) act(glm::dvec2(x + 0.5, y + 0.5), in, out);
            }
        }
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

// Slope between the rays of neighbouring pixels.
double spreadAt(const Projection& projection, const glm::dvec2& pixel, const PixelRay& ray) {
    const auto neighbour = rayThrough(projection, pixel + glm::dvec2(0.5, 0.0));
    if (!neighbour) return 0.0;
    return 2.0 * glm::length(glm::normalize(neighbour->direction) - glm::normalize(ray.direction));
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
            put(met.place, out);
            break;
        case Channel::albedo:
            put(met.baseColor, out);
            break;
        default:
            *out = static_cast<float>(work.labels.empty() ? instance + 1 : work.labels[instance]);
    }
}

}  // namespace

void execute(PassResources&, const PassInput& input, const MeasureFlow& work) {
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

void execute(PassResources& resources, const PassInput& input, const FollowLayer& work) {
    const Scene& scene = input.scene->scene();
    ProcessorTracer& tracer = *input.processorTracer;
    const glm::dmat3 worldAxes(1.0);
    resources.draws.begin(scene, input.pose, work.from.view, worldAxes, input.plan.lights);
    const LayerRays layers(scene, input.pose, input.plan,
                           tracer.beginLookups(input.plan, resources.draws), tracer.origin());
    const bool reflected = work.layer == OutputLayer::reflected;
    forEachPixel(input, work.source, channelsOf(input.plan.channel),
                 [&](const glm::dvec2& pixel, const float* drawn, float* out) {
                     const SurfaceDraw& draw = drawOf(work.draws, drawn);
                     const bool glass = layers.glassOf(draw.instance) != Glass::none;
                     if (!glass && !(reflected && draw.mirrors)) return;
                     const auto ray = rayThrough(work.from, pixel);
                     if (!ray) return;
                     const SurfacePoint seen = surfaceAt(input, draw, drawn, *ray);
                     const double spread = spreadAt(work.from, pixel, *ray);
                     const auto met = reflected ? layers.reflected(*ray, seen, spread)
                                                : layers.refracted(*ray, seen, spread);
                     if (met) putLayer(input.plan, work, *ray, *met, out);
                 });
}

}  // namespace clerestory
