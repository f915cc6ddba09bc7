// Glass scenes, and the optics of panes in double precision to compare with.
#pragma once

#include "reference/reference.h"
#include "sight.h"

#include <glm/gtc/matrix_transform.hpp>

namespace clerestory::test {

class GlassPictures : public GlTest {};

// ---- scenes ------------------------------------------------------------------------------------

inline glm::dmat4 tilted(double z, double degrees) {  // about the vertical
    return glm::rotate(moved(0, 0, z), glm::radians(degrees), glm::dvec3(0, 1, 0));
}

// One mesh, so that it is a body.
inline MeshDraft cube(float half, Index material) {
    MeshDraft draft{.name = "cube", .material = material, .hasNormals = true};
    for (int axis = 0; axis < 3; ++axis) {
        for (int side = -1; side <= 1; side += 2) {
            const auto first = static_cast<std::uint32_t>(draft.vertices.size());
            for (int i = 0; i < 4; ++i) {
                Vertex v;
                v.position[axis] = half * float(side);
                v.position[(axis + 1) % 3] = (i == 1 || i == 2) ? half : -half;
                v.position[(axis + 2) % 3] = i >= 2 ? half : -half;
                v.normal = glm::vec3(0.0f);
                v.normal[axis] = float(side);
                draft.vertices.push_back(v);
            }
            for (const std::uint32_t i : side > 0 ? std::array{0u, 1u, 2u, 0u, 2u, 3u}
                                                  : std::array{0u, 2u, 1u, 0u, 3u, 2u}) {
                draft.indices.push_back(first + i);
            }
        }
    }
    return draft;
}

inline FrameRequest through(Scene scene, const std::string& id, const glm::dvec3& eye = {0, 0, 2}) {
    FrameRequest r = request(std::move(scene), id, eye);
    r.accuracy.glass = GlassMethod::backdrop;
    r.accuracy.planar = PlanarMethod::environment;  // what it mirrors is the map
    return r;
}

// ---- the truth ---------------------------------------------------------------------------------

inline double cosineInside(double cosine, double ior) {
    return std::sqrt(1.0 - (1.0 - cosine * cosine) / (ior * ior));
}
// Unpolarised, from the amplitudes of both polarisations.
inline double fresnel(double cosine, double ior) {
    const double c = cosineInside(cosine, ior);
    const double s = (cosine - ior * c) / (cosine + ior * c);
    const double p = (ior * cosine - c) / (ior * cosine + c);
    return 0.5 * (s * s + p * p);
}
// All bounces between the faces summed; `clear`: what one crossing leaves.
inline double paneTransmits(double cosine, double ior, double clear = 1.0) {
    const double f = fresnel(cosine, ior);
    return (1 - f) * (1 - f) * clear / (1 - f * f * clear * clear);
}
inline double paneReflects(double cosine, double ior) {
    return 1.0 - paneTransmits(cosine, ior);
}

// What the path tracer sees in the dark, by pixels: the red channel.
inline std::vector<double> tracedPixels(const Scene& scene, const FrameRequest& r) {
    const auto truth = traceReference({.scene = scene,
                                       .frame = r,
                                       .environment = constantEnvironment("black", glm::vec3(0.0f)),
                                       .mode = ReferenceMode::full,
                                       .samples = 256});
    std::vector<double> pixels(truth->objectId.size());
    for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = truth->color.floats()[3 * i];
    return pixels;
}

}  // namespace clerestory::test
