#include "light/faces.h"

#include "light/surface_light.h"

#include <cstdint>

namespace clerestory::light {

std::vector<Face> facesOf(const BakeInput& input, const rays::TriangleTree& tree,
                          const rays::PathTracer& tracer) {
    std::vector<bool> mirrored;
    for (const Instance& instance : input.scene->instances) {
        mirrored.push_back(glm::determinant(glm::dmat3(input.pose->worldFromNode[instance.node])) <
                           0.0);
    }
    std::vector<Face> faces(tree.stillTriangles());
    for (std::uint32_t i = 0; i < faces.size(); ++i) {
        const BvhTriangle& t = tree.triangle(i);
        Face& face = faces[i];
        face.normal = glm::cross(t.b - t.a, t.c - t.a);
        const Material& material = input.materials.material(
            *input.scene, input.materials.materialOf(*input.scene, static_cast<Index>(t.instance)));
        face.twoSided = material.doubleSided;
        if (mirrored[static_cast<std::size_t>(t.instance)]) face.normal = -face.normal;
        if (const auto middle = tracer.middleOf(i)) {
            face.albedo = middle->albedo;
            face.through = middle->through;
            face.emitted = middle->emitted;
            face.plain = true;
        }
    }
    return faces;
}

std::vector<FlatMirror> mirrorsOf(const BakeInput& input, const rays::TriangleTree& tree,
                                  std::vector<Face>& faces, const glm::dvec3& origin) {
    const Scene& scene = *input.scene;
    const std::vector<Surface> surfaces = surfacesOf(scene, input.materials);
    std::vector<FlatMirror> mirrors;
    for (const FlatMirror& m : flatMirrors(scene, *input.pose, input.materials, surfaces)) {
        mirrors.push_back(m.relativeTo(origin));
    }
    if (mirrors.empty()) return mirrors;
    for (std::uint32_t i = 0; i < faces.size(); ++i) {
        const BvhTriangle& t = tree.triangle(i);
        const auto first = 3 * static_cast<std::uint32_t>(t.triangle);
        for (std::size_t k = 0; k < mirrors.size() && faces[i].plain; ++k) {
            const Surface& s = surfaces[mirrors[k].surface];
            // The clusters of a flat part follow each other in Scene::indices.
            const Cluster& begin = scene.clusters[s.firstCluster];
            const Cluster& last = scene.clusters[s.firstCluster + s.clusterCount - 1];
            if (s.instance == static_cast<Index>(t.instance) && first >= begin.firstIndex &&
                first < last.firstIndex + last.indexCount) {
                faces[i].mirror = static_cast<std::uint8_t>(k);
            }
        }
    }
    return mirrors;
}

std::vector<Emitter> emittersOf(const BakeInput& input, const rays::TriangleTree& tree,
                                std::vector<Face>& faces) {
    std::vector<Emitter> emitters;
    if (!input.emission) return emitters;
    double sum = 0.0;
    std::vector<std::uint32_t> places;
    for (std::uint32_t i = 0; i < faces.size(); ++i) {
        const BvhTriangle& t = tree.triangle(i);
        const Material& material = input.materials.material(
            *input.scene, input.materials.materialOf(*input.scene, static_cast<Index>(t.instance)));
        const float radiance = material.unlit ? 0.0f : luminance(emittedRadiance(material));
        Emitter emitter{t.a, t.b - t.a, t.c - t.a};
        const float area = 0.5f * glm::length(glm::cross(emitter.ab, emitter.ac));
        if (!(radiance > 0.0f) || !(area > 0.0f)) continue;
        sum += double{radiance} * area;
        emitter.end = sum;
        emitter.density = radiance;
        emitter.plain = faces[i].plain;
        emitters.push_back(emitter);
        places.push_back(i);
    }
    for (std::size_t i = 0; i < emitters.size(); ++i) {
        Emitter& emitter = emitters[i];
        emitter.end /= sum;
        emitter.density = static_cast<float>(emitter.density / sum);
        if (emitter.plain) faces[places[i]].density = emitter.density;
    }
    return emitters;
}

}  // namespace clerestory::light
