// Ground truth for comparisons: a path tracer over the posed scene, with its own camera, Fresnel,
// microfacets, texture reads and light. It shares the CPU scene, its classification and the request
// with the renderer, and nothing else; it knows no OpenGL.
//
// Two modes:
//   effects  The renderer's own model of light with every effect carried out exactly. Lamps cast no
//            shadows, the environment lights diffuse surfaces unoccluded (times the occlusion
//            texture), emitters light nothing, nothing diffuse is lit by anything diffuse. The
//            specular lobe of mirrors, flat or curved, of smooth dielectrics of any shape, and
//            everything glass sends on, is traced through the real scene to any depth. Lobes the
//            renderer calls dull, rough or cut out (scene/classification.h, Why) see the unoccluded
//            environment, as they do there: what is missing of global illumination is not blamed
//            on a mirror. A switch of FrameRequest::effects that is off is off here, too: its
//            surfaces then see the environment, or are opaque, or do not glow.
//   full     Global illumination: shadows, light from emitters and from diffuse surfaces; occlusion
//            textures are not used. Lamps shine through glass straight on, dimmed, without
//            caustics.
//
// Choices both modes share with the renderer, so that they can be compared: glTF's mix of diffuse
// and specular under lamps; highlights of lamps are never narrower than roughness 0.045; lobes
// return what several bounces between facets add (Turquin 2019); absorption and tint of glass as
// glTF has them; which glass is a pane and which a solid comes from the classification; the sides
// that are not drawn are not met.
#pragma once

#include "image/image.h"
#include "plan/planner.h"
#include "plan/request/frame_request.h"
#include "scene/environment.h"
#include "scene/scene.h"

#include <functional>
#include <optional>

namespace clerestory {

enum class ReferenceMode { effects, full };

inline constexpr std::uint32_t kMaxReferenceSamples = 65536;
inline constexpr std::uint32_t kMaxReferenceThreads = 256;

struct ReferenceRequest {
    const Scene& scene;  // with the texels of its images: not the copy that a Renderer keeps
    // Camera, size, time, effects, environment and overrides are read; accuracy, tone map, exposure
    // and output are not.
    const FrameRequest& frame;
    const EnvironmentMap& environment;  // the map that lights the scene
    EnvironmentMaps maps = {};          // those that materials name
    ReferenceMode mode = ReferenceMode::effects;
    std::uint32_t samples = 64;  // a pixel, 2 ... kMaxReferenceSamples; odd ones are rounded up
    std::uint64_t seed = 1;
    std::uint32_t threads = 0;  // 0: one for each processor; the picture is the same for any number
};

// What a pixel's centre sees first, straight on: the masks that errors are taken over.
enum class FirstHit : std::uint8_t {
    nothing,
    surface,       // neither glass nor a mirror
    glass,         // a pane or a solid
    flatMirror,    // Reflector::flat of the classification
    curvedMirror,  // Reflector::curved
};

struct ReferenceImage {
    Image color;  // float32, 3 channels: linear radiance before exposure and tone mapping, not
                  // clamped
    // float32, 3 channels: half the distance of the two halves of the samples, which are
    // independent: an estimate of the standard error of each number of `color`.
    Image noise;
    double noiseFloor = 0.0;              // root of the mean square of `noise`
    std::vector<std::uint32_t> objectId;  // a pixel each: instance + 1, 0 where nothing is
    std::vector<FirstHit> firstHit;       // a pixel each
    std::uint32_t samples = 0;            // that were taken of each pixel
    // Samples that were not finite and count as black; 0 unless there is a bug.
    std::uint64_t nonFinite = 0;
};

// Traces with threads of its own and returns when all is done. `progress` is called from the
// calling thread with the share that is done, 0 to 1, some ten times a second; once it returns
// false the rest is cancelled, within some milliseconds a thread, and nothing is returned. Same
// request, same bytes, on the same machine, whatever the number of threads. Throws InvalidRequest
// when the request names a camera or a node the scene lacks, and std::invalid_argument for numbers
// out of range or a scene whose images hold no texels.
std::optional<ReferenceImage> traceReference(const ReferenceRequest& request,
                                             const std::function<bool(double)>& progress = {});

}  // namespace clerestory
