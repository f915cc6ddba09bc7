#include "scene/join.h"

#include "scene/default_view.h"
#include "scene/hash.h"
#include "scene/mesh_builder.h"

#include <algorithm>
#include <set>

namespace clerestory {
namespace {

std::vector<std::string> partNames(const std::vector<PlacedScene>& placed) {
    std::set<std::string> used;
    for (const PlacedScene& p : placed) {
        if (p.name) used.insert(*p.name);
    }
    std::vector<std::string> names;
    for (const PlacedScene& p : placed) {
        std::string name = p.name.value_or(p.scene);
        for (int number = 2; !p.name && !used.insert(name).second; ++number) {
            name = p.scene + " " + std::to_string(number);
        }
        names.push_back(std::move(name));
    }
    return names;
}

// Appends the lists of one part. Indices of the part begin at the sizes of the whole's lists.
class Appender {
public:
    Appender(Scene& whole, const ScenePart& part)
        : whole_(whole), part_(*part.scene), prefix_(part.name + "/"), before_(sizesOf(whole)) {}

    void run(const glm::dmat4& worldFromScene, const std::string& name) {
        addGeometry();
        addMaterials();
        addNodes(worldFromScene, name);
        addPlaced();
        addMotion();
    }

private:
    struct Sizes {
        Index vertices, indices, clusters, flatParts, meshes, materials, images, textures, nodes,
            lights, cameras, movingNodes, morphWeights, animatedLights, skins, deformations;
    };
    static Sizes sizesOf(const Scene& s) {
        const auto size = [](const auto& list) { return static_cast<Index>(list.size()); };
        return {
            size(s.vertices),       size(s.indices),   size(s.clusters),    size(s.flatParts),
            size(s.meshes),         size(s.materials), size(s.images),      size(s.textures),
            size(s.nodes) + 1,  // after that of the part
            size(s.lights),         size(s.cameras),   size(s.movingNodes), size(s.morphWeights),
            size(s.animatedLights), size(s.skins),     size(s.deformations)};
    }
    static Index moved(Index index, Index first) { return index == kNone ? kNone : index + first; }
    std::string named(const std::string& name) const { return prefix_ + name; }

    void addGeometry() {
        whole_.vertices.insert(whole_.vertices.end(), part_.vertices.begin(), part_.vertices.end());
        for (const std::uint32_t i : part_.indices) whole_.indices.push_back(i + before_.vertices);
        endTriple(whole_.indices);
        for (Cluster c : part_.clusters) {
            c.firstIndex += before_.indices;
            whole_.clusters.push_back(c);
        }
        for (FlatPart p : part_.flatParts) {
            p.firstCluster += before_.clusters;
            whole_.flatParts.push_back(p);
        }
        for (Mesh m : part_.meshes) {
            m.firstCluster += before_.clusters;
            m.firstFlatPart += before_.flatParts;
            m.material += before_.materials;
            m.deformation = moved(m.deformation, before_.deformations);
            whole_.meshes.push_back(std::move(m));
        }
    }

    void addMaterials() {
        for (const TextureImage& image : part_.images) {
            whole_.images.push_back({.name = image.name,
                                     .width = image.width,
                                     .height = image.height,
                                     .levels = image.levels,
                                     .colorSpace = image.colorSpace,
                                     .hasAlpha = image.hasAlpha,
                                     .packedNormal = image.packedNormal,
                                     .mean = image.mean,
                                     .leastGreen = image.leastGreen,
                                     .slope = image.slope});
        }
        for (Texture t : part_.textures) {
            t.image = moved(t.image, before_.images);
            whole_.textures.push_back(t);
        }
        for (Material m : part_.materials) {
            m.name = named(m.name);
            if (!m.probe.empty()) m.probe = named(m.probe);
            for (TextureSlot* slot : textureSlots(m)) {
                slot->texture = moved(slot->texture, before_.textures);
            }
            whole_.materials.push_back(std::move(m));
        }
        for (Variant v : part_.variants) {
            v.name = named(v.name);
            for (Variant::Choice& choice : v.choices) {
                choice.mesh += before_.meshes;
                choice.material += before_.materials;
            }
            whole_.variants.push_back(std::move(v));
        }
    }

    // Nodes of skinned meshes stay roots; their joints follow the part.
    void addNodes(const glm::dmat4& worldFromScene, const std::string& name) {
        std::vector<bool> skinned(part_.nodes.size());
        for (const Instance& i : part_.instances) {
            const Index deformation = part_.meshes[i.mesh].deformation;
            if (deformation != kNone && part_.deformations[deformation].skin != kNone) {
                skinned[i.node] = true;
            }
        }
        const Index root = addNode(whole_, name, worldFromScene);
        for (std::size_t i = 0; i < part_.nodes.size(); ++i) {
            Node n = part_.nodes[i];
            n.name = named(n.name);
            if (n.parent != kNone) {
                n.parent += before_.nodes;
            } else if (!skinned[i]) {
                n.parent = root;
            }
            whole_.nodes.push_back(std::move(n));
        }
    }

    void addPlaced() {
        for (const Instance& i : part_.instances) {
            whole_.instances.push_back(
                {i.node + before_.nodes, i.mesh + before_.meshes, i.material + before_.materials});
        }
        // What has no node is relative to the part's.
        const auto nodeOf = [&](Index node) {
            return node == kNone ? before_.nodes - 1 : node + before_.nodes;
        };
        for (Light l : part_.lights) {
            l.name = named(l.name);
            l.node = nodeOf(l.node);
            whole_.lights.push_back(std::move(l));
        }
        for (Camera c : part_.cameras) {
            c.name = named(c.name);
            c.node = nodeOf(c.node);
            whole_.cameras.push_back(std::move(c));
        }
        for (Probe p : part_.probes) {
            p.name = named(p.name);
            p.node = nodeOf(p.node);
            whole_.probes.push_back(std::move(p));
        }
    }

    Index firstTarget(AnimatedProperty property) const {
        switch (property) {
            case AnimatedProperty::weights:
                return before_.morphWeights;
            case AnimatedProperty::visible:
                return before_.nodes;
            case AnimatedProperty::material:
                return before_.materials;
            case AnimatedProperty::light:
                return before_.animatedLights;
            case AnimatedProperty::camera:
                return before_.cameras;
            default:
                return before_.movingNodes;
        }
    }

    void addMotion() {
        for (Clip clip : part_.clips) {
            clip.name = named(clip.name);
            for (Track& track : clip.tracks) track.target += firstTarget(track.property);
            whole_.clips.push_back(std::move(clip));
        }
        for (MovingNode m : part_.movingNodes) {
            m.node += before_.nodes;
            whole_.movingNodes.push_back(m);
        }
        for (MorphWeights w : part_.morphWeights) {
            w.node += before_.nodes;
            whole_.morphWeights.push_back(std::move(w));
        }
        for (AnimatedLight l : part_.animatedLights) {
            l.light += before_.lights;
            whole_.animatedLights.push_back(l);
        }
        for (Skin s : part_.skins) {
            for (Index& joint : s.joints) joint += before_.nodes;
            whole_.skins.push_back(std::move(s));
        }
        for (Deformation d : part_.deformations) {
            d.mesh += before_.meshes;
            d.firstVertex += before_.vertices;
            d.skin = moved(d.skin, before_.skins);
            d.weights = moved(d.weights, before_.morphWeights);
            whole_.deformations.push_back(std::move(d));
        }
    }

    Scene& whole_;
    const Scene& part_;
    const std::string prefix_;
    const Sizes before_;
};

}  // namespace

std::vector<FieldError> problems(const std::vector<PlacedScene>& parts,
                                 const std::string& pointer) {
    std::vector<FieldError> errors;
    std::set<std::string> names;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const std::string at = pointer + "/" + std::to_string(i);
        for (FieldError& e : problems(partsOf(parts[i]), at)) errors.push_back(std::move(e));
        if (!parts[i].name) continue;
        if (parts[i].name->empty()) {
            errors.push_back({at + "/name", "is empty", "a name, or leave it out"});
        } else if (!names.insert(*parts[i].name).second) {
            errors.push_back({at + "/name", "is the name of two scenes", "a unique name"});
        }
    }
    return errors;
}

std::vector<ScenePart> scenePartsOf(const std::vector<PlacedScene>& placed,
                                    std::span<const Scene* const> scenes) {
    const std::vector<std::string> names = partNames(placed);
    std::vector<ScenePart> parts;
    for (std::size_t i = 0; i < placed.size(); ++i) {
        parts.push_back({scenes[i], names[i], changed(glm::dmat4(1.0), partsOf(placed[i]))});
    }
    return parts;
}

std::uint64_t contentHash(const std::vector<ScenePart>& parts) {
    ContentHash hash;
    hash.add(parts.size());
    for (const ScenePart& part : parts) {
        hash.add(part.scene->contentHash);
        hash.add(part.name);
        hash.add(part.worldFromScene);
    }
    return hash.value();
}

std::uint64_t geometryBytes(const Scene& scene) {
    return scene.vertices.size() * sizeof(Vertex) + scene.indices.size() * sizeof(std::uint32_t);
}

FieldError problemOf(const std::length_error& tooLarge) {
    return {"/scene", tooLarge.what(),
            "at most " + std::to_string(kMaxJoinedBytes >> 20) + " MiB of vertices"};
}

Scene joined(const std::vector<ScenePart>& parts) {
    std::uint64_t bytes = 0;
    for (const ScenePart& part : parts) bytes += geometryBytes(*part.scene);
    if (bytes > kMaxJoinedBytes) throw std::length_error("the scenes are too large together");
    const Scene& first = *parts.front().scene;
    Scene whole;
    whole.id = first.id;
    whole.title = first.title;
    whole.environment = first.environment;
    whole.environmentRotation = first.environmentRotation;
    for (const ScenePart& part : parts) Appender(whole, part).run(part.worldFromScene, part.name);
    if (!whole.clips.empty() || !whole.deformations.empty()) finishMotion(whole);
    whole.defaultView = fittedView(whole);
    whole.contentHash = contentHash(parts);
    return whole;
}

void copyTexels(Scene& whole, const std::vector<ScenePart>& parts) {
    auto image = whole.images.begin();
    for (const ScenePart& part : parts) {
        for (const TextureImage& source : part.scene->images) (image++)->texels = source.texels;
    }
}

std::vector<std::string> explained(const std::vector<PlacedScene>& parts) {
    const std::vector<std::string> names = partNames(parts);
    std::vector<std::string> lines;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        std::string line = "scene " + parts[i].scene;
        if (names[i] != parts[i].scene) line += " as " + names[i];
        lines.push_back(line + (partsOf(parts[i]).any() ? ": transformed" : ": not transformed"));
    }
    return lines;
}

}  // namespace clerestory
