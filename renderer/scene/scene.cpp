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

namespace {

void addGeometry(ContentHash& h, const Scene& scene) {
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
}

void addAppearance(ContentHash& h, const Scene& scene) {
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
}

// The bindings name every member, so that a new one does not compile until it is handled here.
void addLight(ContentHash& h, const Light& light) {
    const auto& [name, node, kind, intensity, range, inner, outer, radius, position, direction] =
        light;
    h.add(name);
    h.add(node);
    h.add(kind);
    h.add(intensity);
    for (const float v : {range, inner, outer, radius}) h.add(v);
    for (const std::optional<glm::dvec3>& v : {position, direction}) {
        h.add(v.has_value());
        if (v) h.add(*v);
    }
}

void addCamera(ContentHash& h, const Camera& camera) {
    const auto& [name, node, orthographic, yfov, yHalfHeight, znear, zfar] = camera;
    h.add(name);
    h.add(node);
    h.add(orthographic);
    for (const double v : {yfov, yHalfHeight, znear, zfar}) h.add(v);
}

void addProbe(ContentHash& h, const Probe& probe) {
    const auto& [name, node, position, size, resolution, zfar, blur] = probe;
    h.add(name);
    h.add(node);
    h.add(position);
    h.add(size);
    h.add(resolution);
    h.add(zfar);
    add(h, blur);
}

// With what is at them.
void addNodes(ContentHash& h, const Scene& scene) {
    for (const Node& n : scene.nodes) {
        const auto& [name, parent, parentFromLocal, visible] = n;
        h.add(name);
        h.add(parent);
        h.add(parentFromLocal);
        h.add(visible);
    }
    for (const Instance& i : scene.instances) {
        const auto& [node, mesh, material] = i;
        for (const Index v : {node, mesh, material}) h.add(v);
    }
    for (const Light& light : scene.lights) addLight(h, light);
    for (const Camera& camera : scene.cameras) addCamera(h, camera);
    for (const Probe& probe : scene.probes) addProbe(h, probe);
}

}  // namespace

void updateContentHash(Scene& scene) {
    ContentHash h;
    addGeometry(h, scene);
    addAppearance(h, scene);
    addNodes(h, scene);
    addMotion(h, scene);
    for (const Variant& variant : scene.variants) {
        h.add(variant.name);
        for (const Variant::Choice& choice : variant.choices) {
            h.add(choice.mesh);
            h.add(choice.material);
        }
    }
    if (scene.defaultView) {
        const auto& [position, target, yfov, fit] = *scene.defaultView;
        h.add(position);
        h.add(target);
        h.add(yfov);
        h.add(fit);
    }
    h.add(scene.environment);
    h.add(scene.environmentRotation);
    scene.contentHash = h.value();
}

}  // namespace clerestory
