// The conditions for sampling clips and deforming meshes.
#include "scene/animation.h"

#include "scene/geometry.h"
#include "scene/scene.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace clerestory {
namespace {

class MotionCheck {
public:
    explicit MotionCheck(const Scene& scene) : scene_(scene) {}

    std::vector<std::string> run() {
        targets();
        clips();
        skins();
        for (Index i = 0; i < scene_.deformations.size(); ++i) {
            deformation(scene_.deformations[i], i);
        }
        for (Index i = 0; i < scene_.meshes.size(); ++i) {
            const Index d = scene_.meshes[i].deformation;
            require(
                d == kNone || (d < scene_.deformations.size() && scene_.deformations[d].mesh == i),
                "a mesh has no such deformation", i);
        }
        for (const Bounds& reach : {scene_.reach, scene_.motionReach}) {
            require(reach.empty() || (finite(reach.min) && finite(reach.max)),
                    "the scene's reach is not finite", 0);
        }
        return std::move(problems_);
    }

private:
    void require(bool holds, const char* what, std::size_t index) {
        constexpr std::size_t kEnough = 20;
        if (!holds && problems_.size() < kEnough) {
            problems_.push_back(std::string(what) + " (number " + std::to_string(index) + ")");
        }
    }

    void targets() {
        std::set<Index> seen;
        for (std::size_t i = 0; i < scene_.movingNodes.size(); ++i) {
            const MovingNode& n = scene_.movingNodes[i];
            require(n.node < scene_.nodes.size() && seen.insert(n.node).second &&
                        inReach(matrixOf(n.rest)) &&
                        std::abs(glm::length(n.rest.rotation) - 1.0) < 1e-6,
                    "a moving node is out of range", i);
        }
        for (std::size_t i = 0; i < scene_.morphWeights.size(); ++i) {
            const MorphWeights& w = scene_.morphWeights[i];
            require(w.node < scene_.nodes.size() &&
                        std::all_of(w.rest.begin(), w.rest.end(),
                                    [](float v) { return std::abs(v) <= kMaxKey; }),
                    "morph weights are out of range", i);
        }
        for (std::size_t i = 0; i < scene_.animatedLights.size(); ++i) {
            const auto& [light, rest] = scene_.animatedLights[i];
            require(light < scene_.lights.size(), "an animated light is out of range", i);
            fields(rest, [&](const char*, const auto& value, const FactorRange& range) {
                require(inRange(value, range), "an animated light is out of range", i);
            });
        }
    }

    static bool inRange(float v, const FactorRange& range) {
        return v >= range.min && v <= range.max;
    }
    static bool inRange(const glm::vec3& v, const FactorRange& range) {
        return inRange(v.x, range) && inRange(v.y, range) && inRange(v.z, range);
    }

    void clips() {
        std::set<std::string> names;
        for (std::size_t i = 0; i < scene_.clips.size(); ++i) {
            const Clip& clip = scene_.clips[i];
            require(!clip.name.empty() && names.insert(clip.name).second,
                    "a clip has no unique name", i);
            require(std::isfinite(clip.duration) && clip.duration >= 0.0,
                    "a clip's duration is out of range", i);
            for (const Track& c : clip.tracks) {
                require(isValid(c, targetsOf(c.property)), "a clip's track is invalid", i);
            }
        }
    }

    std::size_t targetsOf(AnimatedProperty property) const {
        switch (property) {
            case AnimatedProperty::weights:
                return scene_.morphWeights.size();
            case AnimatedProperty::visible:
                return scene_.nodes.size();
            case AnimatedProperty::material:
                return scene_.materials.size();
            case AnimatedProperty::light:
                return scene_.animatedLights.size();
            case AnimatedProperty::camera:
                return scene_.cameras.size();
            default:
                return scene_.movingNodes.size();
        }
    }

    void skins() {
        for (std::size_t i = 0; i < scene_.skins.size(); ++i) {
            const Skin& s = scene_.skins[i];
            const auto isNode = [&](Index joint) { return joint < scene_.nodes.size(); };
            require(!s.joints.empty() && s.joints.size() == s.jointFromMesh.size() &&
                        std::all_of(s.joints.begin(), s.joints.end(), isNode) &&
                        std::all_of(s.jointFromMesh.begin(), s.jointFromMesh.end(),
                                    [](const glm::dmat4& m) { return inReach(m); }),
                    "a skin is invalid", i);
        }
    }

    void deformation(const Deformation& d, Index i) {
        const bool fits = d.mesh < scene_.meshes.size() && scene_.meshes[d.mesh].deformation == i &&
                          std::uint64_t{d.firstVertex} + d.base.size() <= scene_.vertices.size() &&
                          (d.skin == kNone || d.skin < scene_.skins.size()) &&
                          (d.weights == kNone || d.weights < scene_.morphWeights.size());
        require(fits, "a deformation has no such mesh, vertices, skin or weights", i);
        if (!fits) return;
        require(indicesFit(scene_.meshes[d.mesh], d), "a deformation is not of its mesh", i);
        require(scene_.meshes[d.mesh].flatPartCount == 0, "a deforming mesh has flat parts", i);
        const std::size_t joints = d.skin == kNone ? 0 : scene_.skins[d.skin].joints.size();
        require((d.skin == kNone) == (d.perVertex == 0) && d.perVertex <= 8 &&
                    d.influences.size() == d.perVertex * d.base.size() &&
                    std::all_of(d.influences.begin(), d.influences.end(),
                                [&](const Influence& v) {
                                    return v.joint < joints && v.share >= 0.0f &&
                                           v.share <= 1.0f + 1e-3f;
                                }),
                "a deformation's influences are out of range", i);
        require(std::all_of(d.base.begin(), d.base.end(),
                            [](const BaseVertex& v) {
                                return finite(v.position) && finite(v.normal) && finite(v.tangent);
                            }),
                "a deformation's vertex is not finite", i);
        const auto& first = d.firstDelta;
        require((first.empty() ? d.deltas.empty()
                               : first.front() == 0 && first.back() == d.deltas.size() &&
                                     std::is_sorted(first.begin(), first.end())) &&
                    std::all_of(d.deltas.begin(), d.deltas.end(),
                                [&](const MorphDelta& v) {
                                    return v.vertex < d.base.size() && finite(v.position) &&
                                           finite(v.normal) && finite(v.tangent);
                                }),
                "a deformation's morph targets are out of range", i);
    }

    bool indicesFit(const Mesh& mesh, const Deformation& d) const {
        if (mesh.clusterCount == 0) return false;
        std::uint64_t next = scene_.clusters[mesh.firstCluster].firstIndex;
        for (std::uint32_t c = 0; c < mesh.clusterCount; ++c) {
            const Cluster& cluster = scene_.clusters[mesh.firstCluster + c];
            if (cluster.firstIndex != next) return false;
            next += cluster.indexCount;
            for (std::uint32_t k = 0; k < cluster.indexCount; ++k) {
                const std::uint32_t index = scene_.indices[cluster.firstIndex + k];
                if (index < d.firstVertex || index - d.firstVertex >= d.base.size()) return false;
            }
        }
        return true;
    }

    const Scene& scene_;
    std::vector<std::string> problems_;
};

}  // namespace

std::vector<std::string> motionProblems(const Scene& scene) {
    return MotionCheck(scene).run();
}

}  // namespace clerestory
