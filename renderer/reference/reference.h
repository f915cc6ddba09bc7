// Ground truth for comparisons: a path tracer over the posed scene with its own camera, Fresnel
// equations, microfacets, texture reads and lights. It shares the CPU scene, its classification and
// the request with the renderer, and no other code; no OpenGL.
//
// Rays start from a pixel by the exact inverse of the lens (plan/lens/lens.h).
//
// Definitions that both modes share with the renderer, so that they can be compared: glTF's mix of
// diffuse and specular under punctual lights; highlights of punctual lights have at least roughness
// 0.045; lobes include multiple scattering between microfacets (Turquin 2019); absorption and tint
// of glass are those of glTF; the classification decides which glass is a pane and which a solid;
// culled sides are not hit. Lines and points are left out: only the renderer draws them.
#pragma once

#include "image/image.h"
#include "plan/graph/frame_context.h"
#include "plan/request/frame_request.h"
#include "reference/mode.h"
#include "scene/environment.h"
#include "scene/scene.h"

#include <functional>
#include <optional>

namespace clerestory {

inline constexpr std::uint32_t kMaxReferenceSamples = 65536;
inline constexpr std::uint32_t kMaxReferenceThreads = 256;

struct ReferenceRequest {
    const Scene& scene;  // must have the texels of its images, which a Renderer's copy does not
    // Accuracy, tone map, exposure and output are ignored.
    const FrameRequest& frame;
    const EnvironmentMap& environment;  // the scene's environment map
    EnvironmentMaps maps = {};          // those that materials refer to
    ReferenceMode mode = ReferenceMode::effects;
    std::uint32_t samples = 64;  // per pixel, 2 to kMaxReferenceSamples; odd numbers are rounded up
    std::uint64_t seed = 1;
    std::uint32_t threads = 0;  // 0: one per processor; the image does not depend on it
};

// The first surface at a pixel's centre: the masks for error measures.
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
    // float32, 3 channels: half the difference between the means of two independent halves of the
    // samples, an estimate of the standard error of `color`.
    Image noise;
    double noiseFloor = 0.0;              // root mean square of `noise`
    std::vector<std::uint32_t> objectId;  // per pixel: instance + 1, 0 for the background
    std::vector<FirstHit> firstHit;       // per pixel
    std::uint32_t samples = 0;            // per pixel, as traced
    // Samples that were not finite and were replaced by black; above 0 only if there is a bug.
    std::uint64_t nonFinite = 0;
};

// Traces with its own threads and returns when all pixels are done. `progress` is called on the
// calling thread about ten times a second with the completed fraction, 0 to 1; if it returns false,
// tracing is cancelled within milliseconds and nothing is returned. The same request gives the same
// bytes on the same machine for any number of threads. Throws InvalidRequest if the request names a
// camera or a node that the scene does not have, and std::invalid_argument for values out of range
// or a scene whose images have no texels.
std::optional<ReferenceImage> traceReference(const ReferenceRequest& request,
                                             const std::function<bool(double)>& progress = {});

}  // namespace clerestory
