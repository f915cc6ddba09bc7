// Poses of a scene: samples clips, computes node transforms, deforms meshes.
#include "scene/scene.h"

#include "scene/animated_field.h"
#include "scene/hash.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace clerestory {
namespace {

// The values of all clips at one time.
struct Sampled {
    std::vector<Transform> transforms;  // of Scene::movingNodes
    std::vector<bool> touched;          // whether a clip moves the node
    std::vector<std::vector<double>> weights;
    std::map<Index, bool> visible;         // by node, where a clip says so
    std::map<Index, Material> materials;   // where a clip changes them
    std::map<Index, LightFactors> lights;  // by animated light, likewise
    std::map<Index, Camera> cameras;       // likewise
};

// Sets a factor of the target's value, which is `rest` if no track has set another factor yet.
template <class T>
void setFactor(std::map<Index, T>& values, const T& rest, const Track& track,
               std::span<const double> numbers) {
    setNumbers(values.try_emplace(track.target, rest).first->second, track.field, numbers);
}

void apply(const Scene& scene, const Track& track, double time, Sampled& sampled) {
    if (track.property == AnimatedProperty::weights) {
        std::vector<double>& weights = sampled.weights[track.target];
        std::vector<double> values(track.components());
        sample(track, time, values);
        std::copy_n(values.begin(), std::min(values.size(), weights.size()), weights.begin());
        return;
    }
    std::array<double, 4> v{};
    sample(track, time, v);
    switch (track.property) {
        case AnimatedProperty::visible:
            sampled.visible[track.target] = v[0] >= 0.5;
            return;
        case AnimatedProperty::material:
            return setFactor(sampled.materials, scene.materials[track.target], track, v);
        case AnimatedProperty::light:
            return setFactor(sampled.lights, scene.animatedLights[track.target].rest, track, v);
        case AnimatedProperty::camera:
            return setFactor(sampled.cameras, scene.cameras[track.target], track, v);
        default:
            break;
    }
    Transform& t = sampled.transforms[track.target];
    sampled.touched[track.target] = true;
    if (track.property == AnimatedProperty::translation) t.translation = {v[0], v[1], v[2]};
    if (track.property == AnimatedProperty::rotation)
        t.rotation = glm::dquat(v[3], v[0], v[1], v[2]);
    if (track.property == AnimatedProperty::scale) t.scale = {v[0], v[1], v[2]};
}

Sampled sampledAt(const Scene& scene, std::span<const Index> clips, double time) {
    Sampled sampled;
    sampled.touched.assign(scene.movingNodes.size(), false);
    for (const MovingNode& node : scene.movingNodes) sampled.transforms.push_back(node.rest);
    for (const MorphWeights& w : scene.morphWeights) {
        sampled.weights.emplace_back(w.rest.begin(), w.rest.end());
    }
    for (const Index clip : clips) {
        const double local = localTime(scene.clips[clip], time);
        for (const Track& track : scene.clips[clip].tracks) {
            apply(scene, track, local, sampled);
        }
    }
    return sampled;
}

std::vector<glm::dmat4> worldTransforms(const Scene& scene, const Sampled& sampled) {
    std::vector<Index> movingAt(scene.movingNodes.empty() ? 0 : scene.nodes.size(), kNone);
    for (Index i = 0; i < scene.movingNodes.size(); ++i) {
        if (sampled.touched[i]) movingAt[scene.movingNodes[i].node] = i;
    }
    std::vector<glm::dmat4> worldFromNode;
    worldFromNode.reserve(scene.nodes.size());
    for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
        const Node& node = scene.nodes[i];
        const bool moved = !movingAt.empty() && movingAt[i] != kNone;
        const glm::dmat4 local =
            moved ? matrixOf(sampled.transforms[movingAt[i]]) : node.parentFromLocal;
        worldFromNode.push_back(node.parent == kNone ? local : worldFromNode[node.parent] * local);
    }
    return worldFromNode;
}

void setBounds(const Scene& scene, const Mesh& mesh, DeformedMesh& deformed) {
    for (std::uint32_t c = 0; c < mesh.clusterCount; ++c) {
        const Cluster& cluster = scene.clusters[mesh.firstCluster + c];
        Bounds box;
        for (std::uint32_t i = 0; i < cluster.indexCount; ++i) {
            const std::uint32_t index = scene.indices[cluster.firstIndex + i];
            box.add(deformed.vertices[index - deformed.firstVertex].position);
        }
        deformed.clusters.push_back(box);
        deformed.bounds.add(box);
    }
}

// For each skinned mesh the world position that its vertices are relative to: the root node of its
// first instance. Floats relative to the world's origin would be imprecise far from it.
std::map<Index, glm::dvec3> originsOf(const Scene& scene) {
    std::map<Index, glm::dvec3> origins;
    if (scene.skins.empty()) return origins;
    for (const Instance& instance : scene.instances) {
        if (scene.meshes[instance.mesh].deformation == kNone) continue;
        Index root = instance.node;
        while (scene.nodes[root].parent != kNone) root = scene.nodes[root].parent;
        const glm::dmat4& worldFromRoot = scene.nodes[root].parentFromLocal;
        const bool isTranslation = glm::dmat3(worldFromRoot) == glm::dmat3(1.0);
        origins.try_emplace(instance.mesh,
                            isTranslation ? glm::dvec3(worldFromRoot[3]) : glm::dvec3(0.0));
    }
    return origins;
}

std::shared_ptr<const DeformedMesh> deformedAt(const Scene& scene, const Deformation& d,
                                               const Sampled& sampled,
                                               const std::vector<glm::dmat4>& worldFromNode,
                                               const glm::dvec3& origin) {
    std::vector<glm::dmat4> fromJointBind;
    if (d.skin != kNone) {
        const Skin& skin = scene.skins[d.skin];
        for (std::size_t j = 0; j < skin.joints.size(); ++j) {
            glm::dmat4 fromJoint = worldFromNode[skin.joints[j]];
            fromJoint[3] -= glm::dvec4(origin, 0.0);
            fromJointBind.push_back(fromJoint * skin.jointFromMesh[j]);
        }
    }
    std::span<const double> weights;
    if (d.weights != kNone) weights = sampled.weights[d.weights];
    auto result = std::make_shared<DeformedMesh>();
    result->firstVertex = d.firstVertex;
    const auto rest = std::span(scene.vertices).subspan(d.firstVertex, d.base.size());
    deform(d, weights, fromJointBind, rest, result->vertices);
    const Mesh& mesh = scene.meshes[d.mesh];
    if (d.flatNormals) {
        const Cluster& first = scene.clusters[mesh.firstCluster];
        flattenNormals(std::span(scene.indices).subspan(first.firstIndex, 3 * mesh.primitives),
                       d.firstVertex, result->vertices);
    }
    setBounds(scene, mesh, *result);
    result->hash = hashOfBytes(std::as_bytes(std::span(result->vertices)));
    return result;
}

// For each node whether it and all above it are visible; empty: all are.
std::vector<bool> visibleNodes(const Scene& scene, const Sampled& sampled) {
    std::vector<bool> visible;
    const bool all =
        sampled.visible.empty() && std::all_of(scene.nodes.begin(), scene.nodes.end(),
                                               [](const Node& node) { return node.visible; });
    if (all) return visible;
    for (Index i = 0; i < scene.nodes.size(); ++i) {
        const Node& node = scene.nodes[i];
        const auto said = sampled.visible.find(i);
        const bool own = said == sampled.visible.end() ? node.visible : said->second;
        visible.push_back(own && (node.parent == kNone || visible[node.parent]));
    }
    return visible;
}

void hide(const Scene& scene, const std::vector<bool>& visible, Pose& pose) {
    for (const Instance& instance : scene.instances) {
        pose.hidden.push_back(!visible[instance.node]);
    }
    if (std::find(pose.hidden.begin(), pose.hidden.end(), true) == pose.hidden.end()) {
        pose.hidden.clear();
    }
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        if (scene.lights[i].node == kNone || visible[scene.lights[i].node]) continue;
        if (pose.lights.empty()) pose.lights = scene.lights;
        pose.lights[i].intensity = glm::vec3(0.0f);
    }
}

void assign(const LightFactors& from, Light& to) {
    to.intensity = glm::min(from.color * from.intensity, kMaxLightIntensity);
    to.range = from.range;
    to.outerConeAngle = from.outerConeAngle;
    to.innerConeAngle = std::min(from.innerConeAngle, from.outerConeAngle);
}

// Values that are those of the scene are left out: a frame at rest is one without a clip.
void setFactors(const Scene& scene, const Sampled& sampled, Pose& pose) {
    for (const auto& [index, value] : sampled.materials) {
        if (value != scene.materials[index]) pose.materials.push_back({index, value});
    }
    if (!sampled.lights.empty()) pose.lights = scene.lights;
    for (const auto& [index, factors] : sampled.lights) {
        assign(factors, pose.lights[scene.animatedLights[index].light]);
    }
    if (!sampled.cameras.empty()) pose.cameras = scene.cameras;
    for (const auto& [index, camera] : sampled.cameras) pose.cameras[index] = camera;
    const std::vector<bool> visible = visibleNodes(scene, sampled);
    if (!visible.empty()) hide(scene, visible, pose);
}

Pose poseOf(const Scene& scene, const Sampled& sampled) {
    Pose pose{.worldFromNode = worldTransforms(scene, sampled)};
    setFactors(scene, sampled, pose);
    const std::map<Index, glm::dvec3> origins = originsOf(scene);
    for (const Deformation& d : scene.deformations) {
        const auto known = origins.find(d.mesh);
        const glm::dvec3 origin = known == origins.end() ? glm::dvec3(0.0) : known->second;
        pose.deformed.push_back(deformedAt(scene, d, sampled, pose.worldFromNode, origin));
    }
    return pose;
}

// Whether all transforms and bounds are in range: products of animated scales along a deep tree can
// overflow.
bool staysInReach(const Scene& scene, const Pose& pose) {
    return std::all_of(pose.worldFromNode.begin(), pose.worldFromNode.end(),
                       [](const glm::dmat4& m) { return inReach(m); }) &&
           std::all_of(scene.instances.begin(), scene.instances.end(), [&](const Instance& one) {
               return inReach(transformed(boundsOf(pose, scene.meshes[one.mesh]),
                                          pose.worldFromNode[one.node]));
           });
}

// The targets of a clip, by the list that they are in.
using Target = std::pair<AnimatedProperty, Index>;
std::vector<Target> targetsOf(const Clip& clip) {
    std::vector<Target> targets;
    for (const Track& c : clip.tracks) {
        const bool moves = c.property < AnimatedProperty::weights;
        targets.push_back({moves ? AnimatedProperty::translation : c.property, c.target});
    }
    std::sort(targets.begin(), targets.end());
    return targets;
}

}  // namespace

bool haveSameShape(const Pose& a, const Pose& b) {
    return a.worldFromNode == b.worldFromNode && a.hidden == b.hidden &&
           std::ranges::equal(a.deformed, b.deformed, {}, &DeformedMesh::hash, &DeformedMesh::hash);
}

Pose restPose(const Scene& scene) {
    return poseOf(scene, sampledAt(scene, {}, 0.0));
}

Pose poseAt(const Scene& scene, std::span<const Index> clips, double time) {
    if (clips.empty()) return restPose(scene);
    Pose pose = poseOf(scene, sampledAt(scene, clips, time));
    return staysInReach(scene, pose) ? pose : restPose(scene);
}

Pose poseAt(const Scene& scene, double time) {
    return poseAt(scene, defaultClips(scene), time);
}

std::vector<Index> defaultClips(const Scene& scene) {
    std::vector<Index> chosen;
    std::vector<Target> usedTargets;
    for (Index i = 0; i < scene.clips.size(); ++i) {
        const auto targets = targetsOf(scene.clips[i]);
        const bool apart = std::none_of(targets.begin(), targets.end(), [&](const auto& target) {
            return std::binary_search(usedTargets.begin(), usedTargets.end(), target);
        });
        if (!apart) continue;
        chosen.push_back(i);
        usedTargets.insert(usedTargets.end(), targets.begin(), targets.end());
        std::sort(usedTargets.begin(), usedTargets.end());
    }
    return chosen;
}

std::optional<std::vector<Index>> clipsNamed(const Scene& scene,
                                             const std::optional<std::string>& name) {
    if (!name) return defaultClips(scene);
    if (name->empty()) return std::vector<Index>{};
    for (Index i = 0; i < scene.clips.size(); ++i) {
        if (scene.clips[i].name == *name) return std::vector{i};
    }
    return std::nullopt;
}

std::vector<bool> nodesThatMove(const Scene& scene) {
    std::vector<bool> moves(scene.nodes.size(), false);
    for (const MovingNode& node : scene.movingNodes) moves[node.node] = true;
    for (const Clip& clip : scene.clips) {
        for (const Track& track : clip.tracks) {
            if (track.property == AnimatedProperty::visible) moves[track.target] = true;
        }
    }
    for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
        const Index parent = scene.nodes[i].parent;
        if (parent != kNone && moves[parent]) moves[i] = true;
    }
    return moves;
}

std::vector<bool> instancesThatMove(const Scene& scene) {
    const std::vector<bool> nodes = nodesThatMove(scene);
    std::vector<bool> moves;
    for (const Instance& instance : scene.instances) {
        moves.push_back(nodes[instance.node] || scene.meshes[instance.mesh].deformation != kNone);
    }
    return moves;
}

std::vector<bool> instancesThatChange(const Scene& scene) {
    std::vector<bool> changes = instancesThatMove(scene);
    std::vector<bool> materials(scene.materials.size());
    for (const Clip& clip : scene.clips) {
        for (const Track& track : clip.tracks) {
            if (track.property == AnimatedProperty::material) materials[track.target] = true;
        }
    }
    for (std::size_t i = 0; i < changes.size(); ++i) {
        if (materials[scene.instances[i].material]) changes[i] = true;
    }
    return changes;
}

namespace {

void settleAtRest(Scene& scene, const Pose& rest) {
    for (std::size_t i = 0; i < scene.deformations.size(); ++i) {
        const DeformedMesh& deformed = *rest.deformed[i];
        std::copy(deformed.vertices.begin(), deformed.vertices.end(),
                  scene.vertices.begin() + deformed.firstVertex);
        Mesh& mesh = scene.meshes[scene.deformations[i].mesh];
        mesh.bounds = deformed.bounds;
        mesh.area = 0.0;
        for (std::uint32_t c = 0; c < mesh.clusterCount; ++c) {
            Cluster& cluster = scene.clusters[mesh.firstCluster + c];
            cluster.bounds = deformed.clusters[c];
            if (mesh.primitive != Primitive::triangles) continue;
            for (std::uint32_t k = 0; k + 2 < cluster.indexCount; k += 3) {
                const auto corner = [&](std::uint32_t which) {
                    return glm::dvec3(
                        scene.vertices[scene.indices[cluster.firstIndex + k + which]].position);
                };
                mesh.area +=
                    0.5 * glm::length(glm::cross(corner(1) - corner(0), corner(2) - corner(0)));
            }
        }
    }
}

}  // namespace

void finishMotion(Scene& scene) {
    settleAtRest(scene, restPose(scene));
    scene.reach = scene.motionReach = {};
    if (scene.clips.empty()) return;
    // Approximate: the bounds are a measure of the scene's size and not used for culling.
    constexpr int kMoments = 8;
    const std::vector<bool> moves = instancesThatMove(scene);
    const auto add = [&](const Pose& pose) {
        for (Index i = 0; i < scene.instances.size(); ++i) {
            const Bounds bounds = boundsOfInstance(scene, pose, i);
            scene.reach.add(bounds);
            if (moves[i]) scene.motionReach.add(bounds);
        }
    };
    add(restPose(scene));
    for (Index clip = 0; clip < scene.clips.size(); ++clip) {
        for (int i = 0; i < kMoments; ++i) {
            add(poseAt(scene, std::span(&clip, 1), scene.clips[clip].duration * i / kMoments));
        }
    }
}

const DeformedMesh* deformedMesh(const Pose& pose, const Mesh& mesh) {
    return mesh.deformation < pose.deformed.size() ? pose.deformed[mesh.deformation].get()
                                                   : nullptr;
}

MeshVertices verticesOf(const Scene& scene, const Pose& pose, const Mesh& mesh) {
    if (const DeformedMesh* deformed = deformedMesh(pose, mesh)) {
        return {deformed->vertices, deformed->firstVertex};
    }
    return {scene.vertices, 0};
}

const Bounds& boundsOf(const Pose& pose, const Mesh& mesh) {
    const DeformedMesh* deformed = deformedMesh(pose, mesh);
    return deformed ? deformed->bounds : mesh.bounds;
}

const Bounds& boundsOf(const Scene& scene, const Pose& pose, const Mesh& mesh,
                       std::uint32_t cluster) {
    const DeformedMesh* deformed = deformedMesh(pose, mesh);
    return deformed ? deformed->clusters[cluster]
                    : scene.clusters[mesh.firstCluster + cluster].bounds;
}

namespace {

Bounds boundsWithout(Index omitted, const Scene& scene, const Pose& pose) {
    Bounds bounds;
    for (Index i = 0; i < scene.instances.size(); ++i) {
        if (i != omitted) bounds.add(boundsOfInstance(scene, pose, i));
    }
    return bounds;
}

}  // namespace

Bounds boundsOfInstance(const Scene& scene, const Pose& pose, Index instance) {
    const Instance& i = scene.instances[instance];
    return transformed(boundsOf(pose, scene.meshes[i.mesh]), pose.worldFromNode[i.node]);
}

Bounds worldBounds(const Scene& scene, const Pose& pose) {
    return boundsWithout(kNone, scene, pose);
}

Bounds lastingBounds(const Scene& scene, const Pose& pose) {
    if (!scene.reach.empty()) return scene.reach;
    const Bounds bounds = boundsWithout(scene.ground, scene, pose);
    return bounds.empty() ? worldBounds(scene, pose) : bounds;  // the ground alone
}

}  // namespace clerestory
