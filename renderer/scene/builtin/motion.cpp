#include "scene/builtin/motion.h"

#include <glm/gtc/constants.hpp>

#include <algorithm>
#include <cmath>

namespace clerestory::motion {
namespace {

// Appends the mesh and its Deformation without skin and weights. `sources`: as in addMesh().
Deformation& addDeforming(Scene& scene, MeshDraft draft, std::vector<std::uint32_t>& sources) {
    draft.deforms = true;
    const Index mesh = addMesh(scene, std::move(draft), sources);
    Deformation d{
        .mesh = mesh,
        .firstVertex = static_cast<std::uint32_t>(scene.vertices.size() - sources.size())};
    for (std::size_t i = 0; i < sources.size(); ++i) {
        const Vertex& v = scene.vertices[d.firstVertex + i];
        d.base.push_back({v.position, v.normal, v.tangent});
    }
    scene.meshes[mesh].deformation = static_cast<Index>(scene.deformations.size());
    scene.deformations.push_back(std::move(d));
    return scene.deformations.back();
}

}  // namespace

Index addMovingNode(Scene& scene, Index node, const Transform& rest) {
    scene.nodes[node].parentFromLocal = matrixOf(rest);
    scene.movingNodes.push_back({node, rest});
    return static_cast<Index>(scene.movingNodes.size() - 1);
}

std::vector<double> numbers(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}
std::vector<double> numbers(const glm::dquat& q) {
    return {q.x, q.y, q.z, q.w};
}

Track turning(const Scene& scene, Index movingNode, const glm::dvec3& axis, int turns,
              double duration) {
    // Keys at thirds of a turn: half a turn would be ambiguous.
    const int keys = 3 * std::abs(turns);
    Track track{AnimatedProperty::rotation, movingNode, Interpolation::linear, {}, {}};
    for (int i = 0; i <= keys; ++i) {
        const double angle = glm::two_pi<double>() * turns * i / keys;
        const glm::dquat q =
            scene.movingNodes[movingNode].rest.rotation * glm::angleAxis(angle, axis);
        track.times.push_back(static_cast<float>(duration * i / keys));
        for (const double v : numbers(q)) track.values.push_back(static_cast<float>(v));
    }
    return track;
}

Track repeating(AnimatedProperty property, Index target, double duration, int keys,
                const std::function<std::vector<double>(double t)>& value) {
    Track track{property, target, Interpolation::cubicSpline, {}, {}};
    const double step = duration / keys;
    std::vector<std::vector<double>> values;
    for (int i = 0; i < keys; ++i) values.push_back(value(i * step));
    for (int i = 0; i <= keys; ++i) {
        const auto at = [&](int k) -> const std::vector<double>& {
            return values[static_cast<std::size_t>((k + keys) % keys)];
        };
        std::vector<float> slope;
        for (std::size_t n = 0; n < at(i).size(); ++n) {
            slope.push_back(static_cast<float>((at(i + 1)[n] - at(i - 1)[n]) / (2.0 * step)));
        }
        track.times.push_back(static_cast<float>(i * step));
        track.values.insert(track.values.end(), slope.begin(), slope.end());
        track.values.insert(track.values.end(), at(i).begin(), at(i).end());
        track.values.insert(track.values.end(), slope.begin(), slope.end());
    }
    return track;
}

void placeSkinned(Scene& scene, MeshDraft draft, const Influences& influences, Skin skin) {
    constexpr std::uint32_t kPerVertex = 4;
    const std::string name = draft.name;
    std::vector<std::uint32_t> sources;
    Deformation& d = addDeforming(scene, std::move(draft), sources);
    d.skin = static_cast<Index>(scene.skins.size());
    d.perVertex = kPerVertex;
    for (const std::uint32_t source : sources) {
        std::vector<Influence> all = influences[source];
        all.resize(kPerVertex);
        d.influences.insert(d.influences.end(), all.begin(), all.end());
    }
    scene.skins.push_back(std::move(skin));
    addInstance(scene, addNode(scene, name), d.mesh);
}

Index placeMorphing(Scene& scene, MeshDraft draft, Index node,
                    const std::vector<std::vector<MorphDelta>>& targets) {
    std::vector<std::uint32_t> sources;
    Deformation& d = addDeforming(scene, std::move(draft), sources);
    d.weights = static_cast<Index>(scene.morphWeights.size());
    d.firstDelta.push_back(0);
    for (const std::vector<MorphDelta>& target : targets) {
        for (std::uint32_t i = 0; i < sources.size(); ++i) {
            MorphDelta delta = target[sources[i]];
            delta.vertex = i;
            d.deltas.push_back(delta);
        }
        d.firstDelta.push_back(static_cast<std::uint32_t>(d.deltas.size()));
    }
    scene.morphWeights.push_back({node, std::vector<float>(targets.size(), 0.0f)});
    addInstance(scene, node, d.mesh);
    return d.weights;
}

}  // namespace clerestory::motion
