#include "scene/import/base/imported_scene.h"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include "scene/default_view.h"
#include "scene/import/base/clean_text.h"

namespace clerestory {
namespace {

using Reason = ImportError::Reason;

constexpr std::size_t kMaxWarnings = 1000;

// Returns whether the value was changed.
bool clampTo(float& value, const FactorRange& range) {
    const float before = value;
    value = std::isfinite(value) ? std::clamp(value, range.min, range.max) : range.fallback;
    return !(value == before);
}

template <int N>
bool clampTo(glm::vec<N, float>& value, const FactorRange& range) {
    bool changed = false;
    for (int i = 0; i < N; ++i) {
        const float max = i < 3 ? range.max : range.maxCoverage;
        changed |= clampTo(value[i], {range.min, max, range.fallback});
    }
    return changed;
}

// Whether the matrix has no inverse, relative to its longest column, so that tiny scenes are not
// singular.
bool singular(const glm::dmat4& m) {
    double longest = 0.0;
    for (int column = 0; column < 3; ++column) {
        longest = std::max(longest, glm::length(glm::dvec3(m[column])));
    }
    constexpr double kFlat = 1e-12, kSmallest = 1e-30, kLargest = 1e30;
    const double determinant = glm::determinant(glm::dmat3(m));
    const double farthest = glm::length(glm::dvec3(m[3]));
    return !(longest > kSmallest && longest < kLargest && farthest < kLargest &&
             std::abs(determinant) > kFlat * longest * longest * longest);
}

// Changes a transform that maps space to a plane (a scale of 0 along one axis, which exporters
// write for mirrors and decals) so that it has an inverse, with a thickness far below the tolerance
// of flat parts and a positive determinant. Returns whether the transform was changed.
bool thickened(glm::dmat4& m) {
    const glm::dvec3 x(m[0]), y(m[1]), z(m[2]);
    const double longest = std::max({glm::length(x), glm::length(y), glm::length(z)});
    if (!(longest > 1e-30 && longest < 1e30)) return false;
    // The longest cross product of two columns is the normal of the plane.
    const glm::dmat3 cofactors(glm::cross(y, z), glm::cross(z, x), glm::cross(x, y));
    int across = 0;
    for (int i = 1; i < 3; ++i) {
        if (glm::length(cofactors[i]) > glm::length(cofactors[across])) across = i;
    }
    constexpr double kFlat = 1e-12, kThickness = 1e-6;
    const double area = glm::length(cofactors[across]);
    if (!(area > kFlat * longest * longest)) return false;  // a line or a point
    const glm::dvec3 normal = cofactors[across] / area;
    // The null space: perpendicular to all rows.
    const glm::dmat3 rows = glm::transpose(glm::dmat3(m));
    glm::dvec3 nullDirection(0.0);
    for (int i = 0; i < 3; ++i) {
        const glm::dvec3 c = glm::cross(rows[(i + 1) % 3], rows[(i + 2) % 3]);
        if (glm::length(c) > glm::length(nullDirection)) nullDirection = c;
    }
    nullDirection = glm::normalize(nullDirection);
    glm::dmat3 thick =
        glm::dmat3(m) + glm::outerProduct(kThickness * longest * normal, nullDirection);
    if (glm::determinant(thick) < 0.0) {
        thick = glm::dmat3(m) - glm::outerProduct(kThickness * longest * normal, nullDirection);
    }
    for (int i = 0; i < 3; ++i) m[i] = glm::dvec4(thick[i], 0.0);
    return true;
}

void thickenFlatNodes(Scene& scene) {
    for (Node& node : scene.nodes) {
        if (singular(node.parentFromLocal)) thickened(node.parentFromLocal);
    }
}

void dropSingularInstances(Scene& scene) {
    const Pose pose = restPose(scene);
    std::vector<std::uint64_t> dropped(scene.nodes.size(), 0);
    std::erase_if(scene.instances, [&](const Instance& instance) {
        const bool drop = singular(pose.worldFromNode[instance.node]);
        dropped[instance.node] += drop ? 1 : 0;
        return drop;
    });
    for (std::size_t i = 0; i < dropped.size(); ++i) {
        if (dropped[i] > 0) {
            scene.warnings.push_back({"singularTransform", scene.nodes[i].name,
                                      "the transform maps the mesh to a line or a point; it is not "
                                      "drawn",
                                      dropped[i]});
        }
    }
}

void cleanTexts(Scene& scene) {
    scene.title = cleanText(scene.title);
    const auto cleanNames = [](auto& things) {
        for (auto& thing : things) thing.name = cleanText(thing.name);
    };
    cleanNames(scene.meshes);
    cleanNames(scene.images);
    cleanNames(scene.nodes);
    cleanNames(scene.lights);
    cleanNames(scene.cameras);
    cleanNames(scene.probes);
    cleanNames(scene.variants);
    for (Material& m : scene.materials) {
        fields(m, [](const char*, auto& member, const auto& kind) {
            if constexpr (std::is_same_v<std::decay_t<decltype(kind)>, Text>) {
                member = cleanText(member);
            }
        });
    }
    for (ImportWarning& warning : scene.warnings) {
        warning.subject = cleanText(warning.subject);
        warning.message = cleanText(warning.message);
    }
}

}  // namespace

void cleanMaterial(Material& m, Scene& scene) {
    bool changed = false;
    const auto clean = [&](const char*, auto& member, const auto& kind) {
        if constexpr (std::is_same_v<std::decay_t<decltype(kind)>, FactorRange>) {
            changed |= clampTo(member, kind);
        }
    };
    fields(m, clean);
    for (TextureSlot* slot : textureSlots(m)) {
        fields(*slot, clean);
        if (slot->texCoord > 1) {
            slot->texCoord = 0;
            scene.warnings.push_back({"unsupportedTexCoord", m.name,
                                      "a texture uses a third set of texture coordinates; the "
                                      "first set is used instead"});
        }
    }
    if (changed) {
        scene.warnings.push_back(
            {"materialOutOfRange", m.name, "factors outside their range were clamped"});
    }
}

void countPrimitives(std::uint64_t& total, std::uint64_t primitives, const ImportLimits& limits) {
    total += primitives;
    if (total > limits.maxTriangles) {
        throw ImportError(Reason::limit, "the scene has more than " +
                                             std::to_string(limits.maxTriangles) +
                                             " triangles, lines and points");
    }
}

void requireDrawable(const Scene& scene, const ImportLimits& limits) {
    std::uint64_t drawn = 0;
    for (const Instance& instance : scene.instances) {
        drawn += scene.meshes[instance.mesh].primitives;
        if (drawn <= limits.maxDrawn) continue;
        throw ImportError(Reason::limit, "the instances of the scene have more than " +
                                             std::to_string(limits.maxDrawn) +
                                             " triangles, lines and points");
    }
}

void finishScene(Scene& scene) {
    thickenFlatNodes(scene);
    dropSingularInstances(scene);
    if (scene.instances.empty()) {
        std::string message = "the file has no triangles, lines or points to draw";
        if (!scene.warnings.empty()) {  // the likely reason
            const auto degenerate = std::find_if(
                scene.warnings.begin(), scene.warnings.end(),
                [](const ImportWarning& w) { return w.code == "degenerateTriangles"; });
            const ImportWarning& first =
                degenerate == scene.warnings.end() ? scene.warnings.front() : *degenerate;
            message += ": " + (first.subject.empty() ? "" : first.subject + ": ") + first.message;
        }
        throw ImportError(Reason::unsupported, message);
    }
    if (scene.warnings.size() > kMaxWarnings) {
        const std::uint64_t more = scene.warnings.size() - kMaxWarnings;
        scene.warnings.resize(kMaxWarnings);
        scene.warnings.push_back({"moreWarnings", "", "further warnings were omitted", more});
    }
    cleanTexts(scene);
    if (const auto problems = sceneProblems(scene); !problems.empty()) {
        throw ImportError(Reason::malformed, "the scene is invalid: " + problems.front());
    }
    scene.defaultView = chosenView(scene);
    updateContentHash(scene);
}

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

std::string uniqueName(std::set<std::string>& names, const std::string& requestedName,
                       const std::string& kind, std::size_t number) {
    std::string name = cleanText(requestedName);
    if (name.empty()) name = kind + " " + std::to_string(number + 1);
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
