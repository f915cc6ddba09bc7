#include "scene/compose.h"

#include "scene/hash.h"
#include "scene/material_override.h"
#include "scene/spelling.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace clerestory {
namespace {

// ---- transforms --------------------------------------------------------------------------------

// Relative to the product of the lengths of its axes: below this a matrix is as good as flat.
constexpr double kLeastVolume = 1e-9;
constexpr double kMaxAxis = 1e6, kMinAxis = 1e-9;

glm::dmat4 matrixOf(const std::array<double, 16>& m) {
    glm::dmat4 matrix;
    std::copy(m.begin(), m.end(), &matrix[0][0]);
    return matrix;
}

// Empty, or why the matrix is no transform of a node.
std::string problemOf(const glm::dmat4& m) {
    if (m[0].w != 0.0 || m[1].w != 0.0 || m[2].w != 0.0 || m[3].w != 1.0) return "is not affine";
    const glm::dvec3 x(m[0]), y(m[1]), z(m[2]);
    const double lengths[] = {glm::length(x), glm::length(y), glm::length(z)};
    for (const double length : lengths) {
        if (!(length <= kMaxAxis)) return "is too large";
        if (!(length >= kMinAxis)) return "is singular";
    }
    const double volume = std::abs(glm::dot(x, glm::cross(y, z)));
    if (!(volume > kLeastVolume * lengths[0] * lengths[1] * lengths[2])) return "is singular";
    return {};
}

// A mirrored matrix has a negative factor along x. Shear is lost.
Transform transformOf(const glm::dmat4& m) {
    Transform t;
    t.translation = glm::dvec3(m[3]);
    glm::dmat3 axes(m);
    for (int i = 0; i < 3; ++i) {
        const double length = glm::length(axes[i]);
        t.scale[i] = std::max(length, std::numeric_limits<double>::min());
        axes[i] /= t.scale[i];
    }
    if (glm::determinant(axes) < 0.0) {
        t.scale.x = -t.scale.x;
        axes[0] = -axes[0];
    }
    t.rotation = glm::normalize(glm::quat_cast(axes));
    return t;
}

Transform changed(Transform t, const NodeOverride& o) {
    if (o.matrix) return transformOf(matrixOf(*o.matrix));
    if (o.translation) t.translation = *o.translation;
    if (const auto& q = o.rotation) {
        t.rotation = glm::normalize(glm::dquat((*q)[3], (*q)[0], (*q)[1], (*q)[2]));
    }
    if (o.scale) t.scale = *o.scale;
    return t;
}

// Keeps shear where only the translation changes.
glm::dmat4 changed(const glm::dmat4& own, const NodeOverride& o) {
    if (o.matrix) return matrixOf(*o.matrix);
    glm::dmat4 m = own;
    if (o.rotation || o.scale) m = matrixOf(changed(transformOf(own), o));
    if (o.translation) m[3] = glm::dvec4(*o.translation, 1.0);
    return m;
}

bool isTransform(AnimatedProperty property) {
    return property == AnimatedProperty::translation || property == AnimatedProperty::rotation ||
           property == AnimatedProperty::scale;
}

// property: of a transform.
bool replaces(const NodeOverride& o, AnimatedProperty property) {
    if (o.matrix) return true;
    if (property == AnimatedProperty::translation) return o.translation.has_value();
    if (property == AnimatedProperty::rotation) return o.rotation.has_value();
    return o.scale.has_value();
}

// Clips no longer move the node where the override does, or at all if it stays in the world.
void endAnimation(Scene& scene, Index node, const NodeOverride& o, const Transform& rest) {
    const auto isNode = [&](const MovingNode& m) { return m.node == node; };
    const auto moving = std::find_if(scene.movingNodes.begin(), scene.movingNodes.end(), isNode);
    if (moving == scene.movingNodes.end()) return;
    moving->rest = rest;
    const auto target = static_cast<Index>(moving - scene.movingNodes.begin());
    for (Clip& clip : scene.clips) {
        std::erase_if(clip.tracks, [&](const Track& track) {
            return isTransform(track.property) && track.target == target &&
                   (replaces(o, track.property) || o.relativeTo == Space::world);
        });
    }
}

void move(Scene& scene, Index index, const NodeOverride& o) {
    Node& node = scene.nodes[index];
    glm::dmat4 own = node.parentFromLocal;
    if (o.relativeTo == Space::world) {
        for (Index up = node.parent; up != kNone; up = scene.nodes[up].parent) {
            own = scene.nodes[up].parentFromLocal * own;
        }
        node.parent = kNone;
    }
    node.parentFromLocal = changed(own, o);
    endAnimation(scene, index, o, transformOf(node.parentFromLocal));
}

// ---- hash --------------------------------------------------------------------------------------

template <class T>
void addValue(ContentHash& hash, const T& value) {
    if constexpr (requires { hash.add(value); }) {
        hash.add(value);
    } else {
        for (const double number : value) hash.add(number);
    }
}
template <class T>
void addValue(ContentHash& hash, const std::optional<T>& value) {
    hash.add(value.has_value());
    if (value) addValue(hash, *value);
}

void setMaterials(Scene& scene, const Composition& composition) {
    const MaterialBindings bound = bindMaterials(scene, Pose{}, {}, composition.variant);
    for (Index i = 0; i < scene.instances.size(); ++i) {
        scene.instances[i].material = bound.materialOf(scene, i);
    }
    for (Variant& variant : scene.variants) variant.choices.clear();
    for (const NodeOverride& o : composition.nodes) {
        if (!o.material) continue;
        const auto named = [&](const Material& m) { return m.name == *o.material; };
        const auto material = std::find_if(scene.materials.begin(), scene.materials.end(), named);
        if (material == scene.materials.end()) continue;
        const std::vector<bool> chosen = nodesAtOrBelow(scene, o.node);
        for (Instance& instance : scene.instances) {
            if (!chosen[instance.node]) continue;
            instance.material = static_cast<Index>(material - scene.materials.begin());
        }
    }
}

// Sets Node::visible, which clips no longer change. A later entry for the same name wins.
void setVisible(Scene& scene, const Composition& composition) {
    for (const NodeOverride& o : composition.nodes) {
        if (!o.hidden) continue;
        std::vector<bool> changed;
        for (Node& node : scene.nodes) {
            changed.push_back(node.name == o.node);
            if (changed.back()) node.visible = !*o.hidden;
        }
        for (Clip& clip : scene.clips) {
            std::erase_if(clip.tracks, [&](const Track& track) {
                return track.property == AnimatedProperty::visible && changed[track.target];
            });
        }
    }
}

std::vector<bool> hiddenNodes(const Scene& scene, const Composition& composition) {
    std::vector<bool> hidden(scene.nodes.size(), false);
    for (std::size_t i = 0; i < hidden.size(); ++i) {
        const Node& node = scene.nodes[i];
        for (const NodeOverride& o : composition.nodes) {
            if (o.hidden && o.node == node.name) hidden[i] = *o.hidden;
        }
        if (node.parent != kNone && hidden[node.parent]) hidden[i] = true;
    }
    return hidden;
}

}  // namespace

std::vector<FieldError> problems(const Scene& scene, const std::vector<NodeOverride>& nodes,
                                 const std::string& pointer) {
    std::vector<FieldError> errors;
    if (nodes.empty()) return errors;
    const auto names = namesOf(scene.nodes), materials = namesOf(scene.materials);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const NodeOverride& o = nodes[i];
        const std::string at = pointer + "/" + std::to_string(i);
        const auto requireName = [&](const char* what, const std::string& name,
                                     const std::vector<std::string_view>& known) {
            if (std::binary_search(known.begin(), known.end(), std::string_view(name))) return;
            errors.push_back({at + "/" + what,
                              "the scene has no " + std::string(what) + " of this name" +
                                  didYouMean(name, known),
                              known.empty() ? "no " + std::string(what) + " has a name"
                                            : listedNearest(name, known)});
        };
        requireName("node", o.node, names);
        if (o.material) requireName("material", *o.material, materials);
        if (!o.hidden && !o.material && !o.moves()) {
            errors.push_back({at, "changes nothing", "hidden, material or a transform"});
        }
        if (o.matrix && (o.translation || o.rotation || o.scale)) {
            errors.push_back({at + "/matrix", "conflicts with another form of the transform",
                              "matrix, or translation, rotation and scale"});
        }
        if (o.matrix) {
            if (const std::string problem = problemOf(matrixOf(*o.matrix)); !problem.empty()) {
                errors.push_back({at + "/matrix", problem,
                                  "an invertible affine matrix whose axes have lengths from 1e-9 "
                                  "to 1e6; last row 0 0 0 1"});
            }
        }
        const auto flat = [](double factor) { return !(std::abs(factor) >= kMinAxis); };
        if (o.scale && (flat(o.scale->x) || flat(o.scale->y) || flat(o.scale->z))) {
            errors.push_back(
                {at + "/scale", "is singular", "factors whose absolute value is from 1e-9 to 1e6"});
        }
    }
    return errors;
}

std::uint64_t contentHash(const Scene& scene, const Composition& composition) {
    ContentHash hash;
    hash.add(scene.contentHash);
    addValue(hash, composition.variant);
    for (const NodeOverride& node : composition.nodes) {
        fields(node, [&](const char*, const auto& member, auto&&...) { addValue(hash, member); });
    }
    return hash.value();
}

Scene composed(const Scene& scene, const Composition& composition) {
    Scene result = scene;
    result.contentHash = contentHash(scene, composition);
    setMaterials(result, composition);
    bool moved = false;
    for (const NodeOverride& o : composition.nodes) {
        if (!o.moves()) continue;
        for (Index i = 0; i < result.nodes.size(); ++i) {
            if (result.nodes[i].name == o.node) move(result, i, o);
        }
        moved = true;
    }
    setVisible(result, composition);
    const std::vector<bool> hidden = hiddenNodes(scene, composition);
    std::erase_if(result.instances, [&](const Instance& i) { return hidden[i.node]; });
    if (moved && (!result.clips.empty() || !result.deformations.empty())) finishMotion(result);
    return result;
}

std::vector<std::string> explained(const Scene& scene, const Composition& composition) {
    std::vector<std::string> lines;
    for (const NodeOverride& o : composition.nodes) {
        const auto count = std::count_if(scene.nodes.begin(), scene.nodes.end(),
                                         [&](const Node& node) { return node.name == o.node; });
        std::string line = "node " + o.node;
        if (count > 1) line += " (" + std::to_string(count) + " of this name)";
        const char* separator = ": ";
        const auto add = [&](const std::string& text) {
            line += separator + text;
            separator = "; ";
        };
        if (o.hidden) add(*o.hidden ? "hidden" : "shown");
        if (o.material) add("material " + *o.material);
        if (o.moves()) {
            add(o.relativeTo == Space::world ? "moved, relative to the world"
                                             : "moved, relative to its parent");
        }
        lines.push_back(std::move(line));
    }
    return lines;
}

}  // namespace clerestory
