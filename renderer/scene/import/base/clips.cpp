#include "scene/import/base/clips.h"

#include "scene/import/base/cleaning.h"

#include <algorithm>
#include <cmath>

namespace clerestory {

glm::dmat4 worldFromNode(const Scene& scene, Index node) {
    glm::dmat4 world(1.0);
    for (; node != kNone; node = scene.nodes[node].parent) {
        world = scene.nodes[node].parentFromLocal * world;
    }
    return world;
}

glm::dvec3 skinOrigin(const Scene& scene, Index firstJoint) {
    constexpr double kStep = 1000.0;  // metres
    if (firstJoint == kNone) return glm::dvec3(0.0);
    const glm::dmat4 world = worldFromNode(scene, firstJoint);
    return inReach(world) ? kStep * glm::round(glm::dvec3(world[3]) / kStep) : glm::dvec3(0.0);
}

Transform partsOf(const glm::dmat4& matrix) {
    Transform t{.translation = glm::dvec3(matrix[3])};
    glm::dmat3 axes(matrix);
    for (int i = 0; i < 3; ++i) {
        t.scale[i] = glm::length(axes[i]);
        axes[i] = t.scale[i] > 0.0 ? axes[i] / t.scale[i] : glm::dmat3(1.0)[i];
    }
    if (glm::determinant(axes) < 0.0) {
        t.scale.x = -t.scale.x;
        axes[0] = -axes[0];
    }
    const glm::dquat q = glm::quat_cast(axes);
    if (glm::length(q) > 1e-6) t.rotation = glm::normalize(q);
    return t;
}

std::string uniqueClipName(std::set<std::string>& names, const std::string& requestedName,
                           std::size_t number) {
    std::string name = cleanText(requestedName);
    if (name.empty()) name = "clip " + std::to_string(number + 1);
    // Leaves room for the number within the length limit of cleanText().
    if (names.contains(name)) {
        name = cleanText(name.substr(0, 150) + " " + std::to_string(number + 1));
    }
    while (!names.insert(name).second) name += "'";
    return name;
}

Index addMovingNode(Scene& scene, Index node, const Transform& rest) {
    if (!inReach(matrixOf(rest))) return kNone;
    // A node that is hidden at rest must not be removed as singular.
    if (rest.scale.x * rest.scale.y * rest.scale.z == 0.0) {
        scene.nodes[node].parentFromLocal = matrixOf(rest);
    }
    scene.movingNodes.push_back({node, rest});
    return static_cast<Index>(scene.movingNodes.size() - 1);
}

void addClip(Scene& scene, Clip clip, std::uint64_t dropped) {
    if (dropped > 0) {
        scene.warnings.push_back({"badAnimation", clip.name,
                                  "channels without a target in the scene, or with keys that are "
                                  "unsorted or not finite, "
                                  "were skipped",
                                  dropped});
    }
    for (const Track& t : clip.tracks) {
        clip.duration = std::max(clip.duration, double{t.times.back()});
    }
    if (!clip.tracks.empty()) scene.clips.push_back(std::move(clip));
}

}  // namespace clerestory
