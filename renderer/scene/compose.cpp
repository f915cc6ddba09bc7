#include "scene/compose.h"

#include "scene/hash.h"
#include "scene/material_override.h"
#include "scene/name_pattern.h"
#include "scene/spelling.h"

#include <algorithm>

namespace clerestory {
namespace {

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
    node.parentFromLocal = changed(own, partsOf(o));
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
        std::vector<bool> chosen;
        for (Node& node : scene.nodes) {
            chosen.push_back(matchesName(o.node, node.name));
            if (chosen.back()) node.visible = !*o.hidden;
        }
        for (Clip& clip : scene.clips) {
            std::erase_if(clip.tracks, [&](const Track& track) {
                return track.property == AnimatedProperty::visible && chosen[track.target];
            });
        }
    }
}

std::vector<bool> hiddenNodes(const Scene& scene, const Composition& composition) {
    std::vector<bool> hidden(scene.nodes.size(), false);
    for (std::size_t i = 0; i < hidden.size(); ++i) {
        const Node& node = scene.nodes[i];
        for (const NodeOverride& o : composition.nodes) {
            if (o.hidden && matchesName(o.node, node.name)) hidden[i] = *o.hidden;
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
        if (!isNamePattern(o.node)) {
            requireName("node", o.node, names);
        } else if (std::none_of(names.begin(), names.end(),
                                [&](std::string_view name) { return matchesName(o.node, name); })) {
            errors.push_back(matchesNoNode(at + "/node", o.node, names));
        }
        if (o.material) requireName("material", *o.material, materials);
        if (!o.hidden && !o.material && !o.moves()) {
            errors.push_back({at, "changes nothing", "hidden, material or a transform"});
        }
        for (FieldError& e : problems(partsOf(o), at)) errors.push_back(std::move(e));
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
    if (auto ground = composition.ground) {
        ground->shadowCatcher = composition.shadowCatcher;
        hash.add(std::string_view("ground"));
        fields(*ground,
               [&](const char*, const auto& member, auto&&...) { addValue(hash, member); });
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
            if (matchesName(o.node, result.nodes[i].name)) move(result, i, o);
        }
        moved = true;
    }
    setVisible(result, composition);
    const std::vector<bool> hidden = hiddenNodes(scene, composition);
    std::erase_if(result.instances, [&](const Instance& i) { return hidden[i.node]; });
    if (moved && (!result.clips.empty() || !result.deformations.empty())) finishMotion(result);
    if (composition.ground) addGround(result, *composition.ground, composition.shadowCatcher);
    return result;
}

std::vector<std::string> explained(const Scene& scene, const Composition& composition) {
    std::vector<std::string> lines;
    for (const NodeOverride& o : composition.nodes) {
        const auto count =
            std::count_if(scene.nodes.begin(), scene.nodes.end(),
                          [&](const Node& node) { return matchesName(o.node, node.name); });
        std::string line = "node " + o.node;
        if (count > 1)
            line += " (" + std::to_string(count) +
                    (isNamePattern(o.node) ? " nodes)" : " of this name)");
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
    if (composition.ground) {
        lines.push_back(explained(*composition.ground, composition.shadowCatcher));
    }
    return lines;
}

}  // namespace clerestory
