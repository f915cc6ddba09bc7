// Culling, classing and ordering of draws.
#include "plan/draws.h"

#include "plan/features.h"
#include "plan/lighting.h"
#include "plan/visibility.h"

#include <algorithm>
#include <tuple>

namespace clerestory {
namespace {

// A box's rectangle on screen covers more than the surface in it does.
constexpr double kBoxFill = 0.4;

Features materialFeatures(const Material& m, const Mesh& mesh, const Effects& effects) {
    Features f = 0;
    std::vector<const TextureSlot*> used;
    const auto map = [&](const TextureSlot& slot, Features bit) {
        if (slot.present()) {
            f |= bit;
            used.push_back(&slot);
        }
    };
    map(m.baseColorTexture, FEATURE_BASE_COLOR_MAP);
    if (m.unlit) {
        f |= FEATURE_UNLIT;
    } else {
        map(m.metallicRoughnessTexture, FEATURE_METALLIC_ROUGHNESS_MAP);
        if (m.normalScale != 0.0f) map(m.normalTexture, FEATURE_NORMAL_MAP);
        if (m.occlusionStrength > 0.0f) map(m.occlusionTexture, FEATURE_OCCLUSION_MAP);
        const glm::vec3 emitted = emittedRadiance(m);
        if (effects.emission && std::max({emitted.x, emitted.y, emitted.z}) > 0.0f) {
            f |= FEATURE_EMISSION;
            map(m.emissiveTexture, FEATURE_EMISSIVE_MAP);
        }
    }
    for (const TextureSlot* slot : used) {
        if (slot->transformed()) f |= FEATURE_TEXTURE_TRANSFORM;
        if (slot->texCoord == 1) f |= FEATURE_SECOND_TEXCOORD;
    }
    if (mesh.hasColors) f |= FEATURE_VERTEX_COLOR;
    if (m.alphaMode == AlphaMode::mask) f |= FEATURE_MASK;
    if (m.alphaMode == AlphaMode::blend) f |= FEATURE_BLEND;
    if (m.doubleSided) f |= FEATURE_DOUBLE_SIDED;
    return f;
}

struct Candidate {
    Draw draw;
    double distance;  // from the eye to the nearest point of its box, metres
    Index material;
};

// What is culled and ordered as one: a cluster, or the whole of a mesh that is no larger than one
// (its flat parts have clusters of their own, however small).
std::vector<Cluster> piecesOf(const Scene& scene, const Mesh& mesh) {
    const auto first = scene.clusters.begin() + mesh.firstCluster;
    if (mesh.clusterCount == 0) return {};
    if (mesh.triangles <= kClusterTriangles) {
        return {{first->firstIndex, 3 * mesh.triangles, mesh.bounds}};
    }
    return {first, first + mesh.clusterCount};
}

bool continues(const Draw& before, const Draw& next) {
    return before.instance == next.instance && before.features == next.features &&
           before.lights == next.lights && before.firstIndex + before.indexCount == next.firstIndex;
}

std::vector<Draw> merged(const std::vector<Candidate>& candidates) {
    std::vector<Draw> draws;
    for (const Candidate& c : candidates) {
        if (!draws.empty() && continues(draws.back(), c.draw))
            draws.back().indexCount += c.draw.indexCount;
        else
            draws.push_back(c.draw);
    }
    return draws;
}

// Ties are broken by the place in the scene, so that order never depends on the sort.
bool nearer(const Candidate& a, const Candidate& b) {
    return std::tie(a.distance, a.draw.firstIndex, a.draw.instance) <
           std::tie(b.distance, b.draw.firstIndex, b.draw.instance);
}
bool sameStateFirst(const Candidate& a, const Candidate& b) {
    return std::tie(a.draw.features, a.material, a.draw.instance, a.draw.firstIndex) <
           std::tie(b.draw.features, b.material, b.draw.instance, b.draw.firstIndex);
}

std::vector<Draw> depthDraws(std::vector<Candidate> candidates) {
    for (Candidate& c : candidates) {
        c.draw.features &= FEATURE_DOUBLE_SIDED;
        c.draw.lights = {};
    }
    std::sort(candidates.begin(), candidates.end(), nearer);
    return merged(candidates);
}

}  // namespace

ViewDraws drawsFor(const Scene& scene, const Pose& pose, const View& view, const Effects& effects,
                   const std::vector<PlacedLight>& lights) {
    ViewDraws result;
    const Frustum frustum = frustumOf(view);
    std::vector<Candidate> opaque, masked, blended;

    for (const Material& m : scene.materials) {
        const glm::vec3 emitted = emittedRadiance(m);
        result.emissiveInScene |= !m.unlit && std::max({emitted.x, emitted.y, emitted.z}) > 0.0f;
        result.glassInScene |= m.transmission > 0.0f;
    }
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        const Mesh& mesh = scene.meshes[instance.mesh];
        const Material& material = scene.materials[instance.material];
        const glm::dmat4 toEye = eyeFromLocal(view, pose.worldFromNode[instance.node]);
        const std::vector<Cluster> pieces = piecesOf(scene, mesh);
        result.clusters += pieces.size();
        if (outside(frustum, transformed(mesh.bounds, toEye))) {
            result.culled += pieces.size();
            continue;
        }
        const Features features = materialFeatures(material, mesh, effects);
        std::vector<Candidate>& bucket = features & FEATURE_BLEND  ? blended
                                         : features & FEATURE_MASK ? masked
                                                                   : opaque;
        for (const Cluster& cluster : pieces) {
            const Bounds box = transformed(cluster.bounds, toEye);
            if (outside(frustum, box)) {
                ++result.culled;
                continue;
            }
            Draw draw{i, cluster.firstIndex, cluster.indexCount, features, {}};
            if (!material.unlit) {
                std::uint32_t reaching = 0;
                draw.lights = lightsReaching(lights, view.eye, box, reaching);
                if (draw.lights.count > 0) draw.features |= FEATURE_LIGHTS;
                result.mostLights = std::max(result.mostLights, reaching);
            }
            bucket.push_back({draw, distanceTo(box), instance.material});
            if (&bucket == &opaque) result.overdraw += kBoxFill * screenBox(view, box).share();
            result.anyLit |= !material.unlit;
            result.anyEmissive |= (features & FEATURE_EMISSION) != 0;
        }
    }

    const bool prepass = result.overdraw > kPrepassOverdraw;
    if (prepass) result.depth = depthDraws(opaque);
    std::sort(opaque.begin(), opaque.end(), prepass ? sameStateFirst : nearer);
    std::sort(masked.begin(), masked.end(), nearer);
    opaque.insert(opaque.end(), masked.begin(), masked.end());
    result.opaque = merged(opaque);
    std::sort(blended.begin(), blended.end(),
              [](const auto& a, const auto& b) { return nearer(b, a); });
    result.blended = merged(blended);
    return result;
}

}  // namespace clerestory
