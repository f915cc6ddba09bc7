#include "scene/import/gltf/parts.h"

#include "scene/import/base/imported_scene.h"
#include "scene/import/base/types.h"
#include "scene/mesh_builder.h"
#include "scene/transform_parts.h"

#include <algorithm>
#include <cmath>

namespace clerestory {
namespace {

// Of all channels together: a small file could refer to one long accessor many times.
constexpr std::uint64_t kMaxNumbers = 64'000'000;
constexpr std::size_t kMaxUnknownPointers = 20;  // that warnings name

// Its target is added after the clips.
bool isPlacedLater(const Track& track) {
    return track.property == AnimatedProperty::light || track.property == AnimatedProperty::camera;
}

}  // namespace

std::vector<Index> indexList(const Json& parent, const char* key) {
    std::vector<Index> result;
    for (const Json& value : array(parent, key)) {
        if (!value.is_number_unsigned() || value.get<std::uint64_t>() >= kNone) {
            malformed("\"" + std::string(key) + "\" has an element that is not an index");
        }
        result.push_back(value.get<Index>());
    }
    return result;
}

Transform transformOf(const Json& node) {
    const Json& list = array(node, "matrix");
    if (list.size() == 16) {
        glm::dmat4 m(1.0);
        for (int i = 0; i < 16; ++i) {
            const Json& value = list[static_cast<std::size_t>(i)];
            m[i / 4][i % 4] = value.is_number() ? value.get<double>() : 0.0;
        }
        return transformOf(m);
    }
    Transform t{.translation = numbers<3>(node, "translation", glm::dvec3(0.0)),
                .scale = numbers<3>(node, "scale", glm::dvec3(1.0))};
    const glm::dvec4 xyzw = numbers<4>(node, "rotation", glm::dvec4(0.0, 0.0, 0.0, 1.0));
    const double length = glm::length(xyzw);
    if (length > 0.0 && std::isfinite(length)) {
        t.rotation = glm::dquat(xyzw.w, xyzw.x, xyzw.y, xyzw.z) / length;
    }
    return t;
}

GltfSkin gltfSkin(GltfDocument& document, const Json& skin, const std::vector<Index>& nodeOf) {
    GltfSkin result;
    Numbers jointFromMesh;
    if (const Index accessor = indexAt(skin, "inverseBindMatrices"); accessor != kNone) {
        jointFromMesh = document.floats(accessor);
    }
    for (const Index joint : indexList(skin, "joints")) {
        const std::size_t i = result.joints.size();
        result.joints.push_back(joint < nodeOf.size() ? nodeOf[joint] : kNone);
        glm::dmat4 matrix(1.0);
        if (jointFromMesh.components == 16 && i < jointFromMesh.count()) {
            for (int k = 0; k < 16; ++k) {
                matrix[k / 4][k % 4] = static_cast<double>(jointFromMesh.at(i)[k]);
            }
        }
        result.jointFromMesh.push_back(inReach(matrix) ? matrix : glm::dmat4(1.0));
    }
    if (result.joints.empty()) malformed("a skin has no joints");
    return result;
}

void GltfAnimations::readClips() {
    const Json& animations = array(document_.json(), "animations");
    for (std::size_t i = 0; i < animations.size(); ++i) {
        readClip(element(animations, i, "animations"), i);
    }
    nodeMoves_ = nodesThatMove(scene_);
}

void GltfAnimations::readClip(const Json& animation, std::size_t number) {
    Clip clip{.name = uniqueName(names_, text(animation, "name"), "clip", number)};
    std::uint64_t dropped = 0;
    movedByClip_.clear();
    const Json& channels = array(animation, "channels");
    for (std::size_t i = 0; i < channels.size(); ++i) {
        try {
            dropped += addTrack(animation, element(channels, i, "channels"), clip) ? 0 : 1;
        } catch (const ImportError& error) {
            if (error.reason() != ImportError::Reason::malformed) throw;
            ++dropped;
        }
    }
    addClip(scene_, std::move(clip), dropped);
}

bool GltfAnimations::addTrack(const Json& animation, const Json& json, Clip& clip) {
    const Json& sampler =
        element(array(animation, "samplers"), indexAt(json, "sampler"), "samplers");
    const std::string interpolation = text(sampler, "interpolation");
    Track track{.interpolation = interpolation == "STEP"          ? Interpolation::step
                                 : interpolation == "CUBICSPLINE" ? Interpolation::cubicSpline
                                                                  : Interpolation::linear};
    const Numbers times = document_.floats(indexAt(sampler, "input"));
    Numbers values = document_.floats(indexAt(sampler, "output"));
    numbers_ += times.values.size() + values.values.size();
    requireFewNumbers();
    track.times = times.values;
    track.values = std::move(values.values);
    const std::optional<PointerTarget> target = targetOf(object(json, "target"));
    if (!target || times.components != 1) return false;
    track.property = target->property;
    track.field = target->field;
    track.target = 0;
    // Before targets are added to the scene.
    if (!isValid(track, 1)) return false;
    if (!setTarget(target->index, track)) return false;
    if (!movedByClip_.insert({track.property, track.target, track.field}).second) return false;
    clip.tracks.push_back(std::move(track));
    return true;
}

// What a channel animates, in the file's indices.
std::optional<PointerTarget> GltfAnimations::targetOf(const Json& target) {
    std::string path = text(target, "path");
    if (const Json* e = extension(target, "KHR_animation_pointer"); e && path == "pointer") {
        const std::string pointer = text(*e, "pointer");
        std::optional<PointerTarget> found = animatedBy(pointer);
        if (!found && unknownPointers_.insert(pointer).second &&
            unknownPointers_.size() <= kMaxUnknownPointers) {
            scene_.warnings.push_back({"unsupportedAnimation", pointer,
                                       "this property is not animated; it keeps its value"});
        }
        return found;
    }
    const Index node = indexAt(target, "node");
    if (node == kNone || path.find('/') != std::string::npos) return {};
    return animatedBy("/nodes/" + std::to_string(node) + "/" + path);
}

bool GltfAnimations::setTarget(Index index, Track& track) {
    if (track.property == AnimatedProperty::material) return setMaterial(index, track);
    if (isPlacedLater(track)) {
        track.target = index;  // of the file, until placeTracks()
        return true;
    }
    if (index >= nodeOf_.size() || nodeOf_[index] == kNone) return false;
    if (track.property == AnimatedProperty::visible) {
        track.target = nodeOf_[index];
        return true;
    }
    if (track.property != AnimatedProperty::weights) {
        track.target = movingNode(index);
        return track.target != kNone;
    }
    const Index known = weightsOf(index);
    track.target = known != kNone ? known : morphWeights(index);
    return track.target != kNone &&
           track.components() == scene_.morphWeights[track.target].rest.size();
}

// The last material of the scene is glTF's default, which has no pointer. Tangents follow the
// rotation of the normal map at rest.
bool GltfAnimations::setMaterial(Index index, Track& track) {
    const std::size_t ofFile = array(document_.json(), "materials").size();
    if (index >= ofFile || track.field == "normalTexture.rotation") return false;
    track.target = index;
    return true;
}

// One copy of each track of a light or a camera for each that is made from it.
void GltfAnimations::placeTracks(const std::vector<PlacedPart>& lights,
                                 const std::vector<PlacedPart>& cameras) {
    std::map<Index, Index> animated;  // index in animatedLights, by light
    const auto targetOf = [&](AnimatedProperty property, const PlacedPart& part) {
        if (property == AnimatedProperty::camera) return part.added;
        const auto next = static_cast<Index>(scene_.animatedLights.size());
        const auto [known, isNew] = animated.try_emplace(part.added, next);
        if (isNew) scene_.animatedLights.push_back({part.added, part.rest});
        return known->second;
    };
    for (Clip& clip : scene_.clips) {
        std::vector<Track> tracks;
        for (Track& track : clip.tracks) {
            if (!isPlacedLater(track)) {
                tracks.push_back(std::move(track));
                continue;
            }
            for (const PlacedPart& part :
                 track.property == AnimatedProperty::light ? lights : cameras) {
                if (part.ofFile != track.target) continue;
                numbers_ += track.times.size() + track.values.size();
                requireFewNumbers();
                tracks.push_back(track);
                tracks.back().target = targetOf(track.property, part);
            }
        }
        clip.tracks = std::move(tracks);
    }
    std::erase_if(scene_.clips, [](const Clip& clip) { return clip.tracks.empty(); });
}

std::vector<bool> GltfAnimations::nodesThatHide() const {
    std::vector<bool> hides(scene_.nodes.size());
    for (const Clip& clip : scene_.clips) {
        for (const Track& track : clip.tracks) {
            if (track.property == AnimatedProperty::visible) hides[track.target] = true;
        }
    }
    for (std::size_t i = 0; i < hides.size(); ++i) {
        const Index parent = scene_.nodes[i].parent;
        if (parent != kNone && hides[parent]) hides[i] = true;
    }
    return hides;
}

void GltfAnimations::requireFewNumbers() const {
    if (numbers_ <= kMaxNumbers) return;
    throw ImportError(ImportError::Reason::limit, "the animations have too many numbers");
}

Index GltfAnimations::movingNode(Index gltfNode) {
    const Index node = nodeOf_[gltfNode];
    if (const auto known = movingAt_.find(node); known != movingAt_.end()) return known->second;
    const Transform rest = transformOf(document_.item("nodes", gltfNode));
    const Index added = addMovingNode(scene_, node, rest);
    if (added != kNone) movingAt_[node] = added;
    return added;
}

Index GltfAnimations::weightsOf(Index gltfNode) const {
    const auto known = weightsAt_.find(nodeOf_[gltfNode]);
    return known == weightsAt_.end() ? kNone : known->second;
}

Index GltfAnimations::morphWeights(Index gltfNode) {
    const Json& json = document_.item("nodes", gltfNode);
    const Json& mesh = document_.item("meshes", indexAt(json, "mesh"));
    std::size_t targets = 0;
    const Json& primitives = array(mesh, "primitives");
    for (std::size_t i = 0; i < primitives.size(); ++i) {
        targets = std::max(targets, array(element(primitives, i, "primitives"), "targets").size());
    }
    if (targets == 0) return kNone;
    MorphWeights weights{.node = nodeOf_[gltfNode], .rest = std::vector<float>(targets, 0.0f)};
    const Json& rest = json.contains("weights") ? array(json, "weights") : array(mesh, "weights");
    for (std::size_t i = 0; i < std::min(targets, rest.size()); ++i) {
        const double weight = rest[i].is_number() ? rest[i].get<double>() : 0.0;
        if (std::abs(weight) <= double{kMaxKey}) {
            weights.rest[i] = static_cast<float>(weight);
        }
    }
    const Index index = static_cast<Index>(scene_.morphWeights.size());
    scene_.morphWeights.push_back(std::move(weights));
    return weightsAt_[nodeOf_[gltfNode]] = index;
}

bool GltfAnimations::moves(const Json& skin) const {
    const std::vector<Index> joints = indexList(skin, "joints");
    return std::any_of(joints.begin(), joints.end(), [&](Index joint) {
        return joint < nodeOf_.size() && nodeOf_[joint] != kNone && nodeMoves_[nodeOf_[joint]];
    });
}

Index GltfAnimations::addSkin(const Json& json) {
    GltfSkin read = gltfSkin(document_, json, nodeOf_);
    // A joint outside the scene does not move its vertices.
    for (std::size_t i = 0; i < read.joints.size(); ++i) {
        if (read.joints[i] != kNone) continue;
        if (staticNode_ == kNone) staticNode_ = addNode(scene_, "");
        read.joints[i] = staticNode_;
    }
    scene_.skins.push_back({std::move(read.joints), std::move(read.jointFromMesh)});
    return static_cast<Index>(scene_.skins.size() - 1);
}

}  // namespace clerestory
