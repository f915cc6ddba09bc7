// Default view and content hash of a scene. Poses are in pose.cpp, checks in scene_problems.cpp.
#include "scene/scene.h"

#include "scene/hash.h"
#include "scene/name_pattern.h"

#include <cmath>

namespace clerestory {
namespace {

// Structures as their fields, everything else as numbers.
template <class T>
void add(ContentHash& h, const T& value) {
    if constexpr (requires { h.add(value); }) {
        h.add(value);
    } else {
        fields(value, [&](const char*, const auto& member, const auto&...) { add(h, member); });
    }
}

void add(ContentHash& h, const Bounds& b) {
    h.add(b.min);
    h.add(b.max);
}

void addMotion(ContentHash& h, const Scene& scene) {
    for (const Clip& clip : scene.clips) {
        h.add(clip.name);
        h.add(clip.duration);
        for (const Track& c : clip.tracks) {
            h.add(c.property);
            h.add(c.target);
            h.add(c.interpolation);
            h.add(c.times);
            h.add(c.values);
            h.add(c.field);
        }
    }
    for (const MovingNode& n : scene.movingNodes) {
        h.add(n.node);
        h.add(n.rest.translation);
        h.add(n.rest.rotation);
        h.add(n.rest.scale);
    }
    for (const MorphWeights& w : scene.morphWeights) {
        h.add(w.node);
        h.add(w.rest);
    }
    for (const AnimatedLight& l : scene.animatedLights) {
        h.add(l.light);
        add(h, l.rest);
    }
    for (const Skin& s : scene.skins) {
        h.add(s.joints);
        for (const glm::dmat4& m : s.jointFromMesh) h.add(m);
    }
    for (const Deformation& d : scene.deformations) {
        for (const std::uint32_t v : {d.mesh, d.firstVertex, d.skin, d.weights, d.perVertex}) {
            h.add(v);
        }
        h.add(d.base);
        h.add(d.influences);
        h.add(d.firstDelta);
        h.add(d.deltas);
        h.add(d.flatNormals);
    }
}

}  // namespace

// Parents precede their children.
std::vector<bool> nodesAtOrBelow(const Scene& scene, const std::string& name) {
    std::vector<bool> chosen(scene.nodes.size());
    for (std::size_t i = 0; i < chosen.size(); ++i) {
        const Node& node = scene.nodes[i];
        chosen[i] = matchesName(name, node.name) || (node.parent != kNone && chosen[node.parent]);
    }
    return chosen;
}

std::uint64_t primitiveCount(const Scene& scene, Primitive primitive) {
    std::uint64_t count = 0;
    for (const Instance& instance : scene.instances) {
        const Mesh& mesh = scene.meshes[instance.mesh];
        if (mesh.primitive == primitive) count += mesh.primitives;
    }
    return count;
}

std::uint64_t contentHash(const Material& material) {
    ContentHash h;
    add(h, material);
    return h.value();
}

void updateContentHash(Scene& scene) {
    ContentHash h;
    h.add(scene.vertices);
    h.add(scene.indices);
    for (const Cluster& c : scene.clusters) {
        h.add(c.firstIndex);
        h.add(c.indexCount);
    }
    for (const FlatPart& p : scene.flatParts) {
        h.add(p.firstCluster);
        h.add(p.clusterCount);
        h.add(p.normal);
        h.add(p.offset);
    }
    for (const Mesh& m : scene.meshes) {
        h.add(m.name);
        h.add(m.firstCluster);
        h.add(m.clusterCount);
        h.add(m.firstFlatPart);
        h.add(m.flatPartCount);
        h.add(m.primitive);
        h.add(m.lit);
        h.add(m.material);
        add(h, m.bounds);
        h.add(m.hasColors);
        h.add(m.deformation);
    }
    for (const Material& m : scene.materials) add(h, m);
    for (const TextureImage& i : scene.images) {
        h.add(i.width);
        h.add(i.height);
        h.add(i.levels);
        h.add(i.colorSpace);
        h.add(i.packedNormal);
        h.add(i.texels);
    }
    for (const Texture& t : scene.textures) {
        h.add(t.image);
        h.add(t.wrapU);
        h.add(t.wrapV);
        h.add(t.magnify);
        h.add(t.minify);
        h.add(t.useLevels);
    }
    for (const Node& n : scene.nodes) {
        h.add(n.name);
        h.add(n.parent);
        h.add(n.parentFromLocal);
        h.add(n.visible);
    }
    for (const Instance& i : scene.instances) {
        h.add(i.node);
        h.add(i.mesh);
        h.add(i.material);
    }
    for (const Light& l : scene.lights) {
        h.add(l.node);
        h.add(l.kind);
        h.add(l.intensity);
        for (const float v : {l.range, l.innerConeAngle, l.outerConeAngle, l.radius}) h.add(v);
    }
    for (const Camera& c : scene.cameras) {
        h.add(c.name);
        h.add(c.node);
        h.add(c.orthographic);
        for (const double v : {c.yfov, c.yHalfHeight, c.znear, c.zfar}) h.add(v);
    }
    for (const Probe& p : scene.probes) {
        h.add(p.name);
        h.add(p.node);
        h.add(p.position);
        h.add(p.size);
        h.add(p.resolution);
        h.add(p.zfar);
        add(h, p.blur);
    }
    addMotion(h, scene);
    for (const Variant& variant : scene.variants) {
        h.add(variant.name);
        for (const Variant::Choice& choice : variant.choices) {
            h.add(choice.mesh);
            h.add(choice.material);
        }
    }
    if (scene.defaultView) {
        h.add(scene.defaultView->position);
        h.add(scene.defaultView->target);
        h.add(scene.defaultView->yfov);
        h.add(scene.defaultView->fit);
    }
    h.add(scene.environment);
    h.add(scene.environmentRotation);
    scene.contentHash = h.value();
}

}  // namespace clerestory
