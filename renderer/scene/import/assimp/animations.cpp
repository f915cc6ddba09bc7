#include "scene/import/assimp/parts.h"

#include "scene/import/base/imported_scene.h"
#include "scene/mesh_builder.h"
#include "scene/transform_parts.h"

#include <assimp/scene.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace clerestory {
namespace {

// Of files without a rate: that of 3D Studio.
constexpr double kTicksPerSecond = 30.0;

// Largest number of bones per vertex; further ones with the smallest weights are ignored.
constexpr std::size_t kMaxInfluences = 8;

std::array<double, 3> numbersOf(const aiVector3D& v) {
    return {v.x, v.y, v.z};
}
std::array<double, 4> numbersOf(const aiQuaternion& q) {
    const double length = std::hypot(std::hypot(q.x, q.y), std::hypot(q.z, q.w));
    if (!(length > 0.0 && std::isfinite(length))) return {0.0, 0.0, 0.0, 1.0};
    return {q.x / length, q.y / length, q.z / length, q.w / length};
}

// factor: multiplies every value.
template <class Key>
Track trackOf(AnimatedProperty property, std::span<const Key> keys, double ticksPerSecond,
              double firstTick, double factor = 1.0) {
    Track track{.property = property};
    for (const Key& key : keys) {
        track.times.push_back(static_cast<float>((key.mTime - firstTick) / ticksPerSecond));
        for (const double value : numbersOf(key.mValue)) {
            track.values.push_back(static_cast<float>(factor * value));
        }
    }
    return track;
}

// Whether the track never leaves the rest transform. Assimp adds all three kinds of keys to every
// channel, most of them constant.
bool isConstantRest(const Track& track, const Transform& rest) {
    const glm::dquat& q = rest.rotation;
    const bool isRotation = track.property == AnimatedProperty::rotation;
    const glm::dvec3& v = track.property == AnimatedProperty::scale ? rest.scale : rest.translation;
    const glm::dvec4 still = isRotation ? glm::dvec4(q.x, q.y, q.z, q.w) : glm::dvec4(v, 0.0);
    constexpr double kTolerance = 1e-6;  // of float keys
    const double tolerance = kTolerance * glm::length(still);
    const std::size_t n = track.components();
    for (std::size_t key = 0; key < track.times.size(); ++key) {
        glm::dvec4 value(0.0);
        for (std::size_t i = 0; i < n; ++i) {
            value[static_cast<int>(i)] = double{track.values[n * key + i]};
        }
        // q and -q are the same rotation.
        if (isRotation && glm::dot(value, still) < 0.0) value = -value;
        if (!(glm::distance(value, still) <= tolerance)) return false;
    }
    return true;
}

template <class Key>
double firstTickOf(const Key* keys, unsigned count) {
    return count > 0 && std::isfinite(keys[0].mTime) ? keys[0].mTime : 0.0;
}

// The start of the clip: 0, or the first key if that is negative.
double firstTickOf(const aiAnimation& animation) {
    double first = 0.0;
    for (unsigned i = 0; i < animation.mNumChannels; ++i) {
        const aiNodeAnim& c = *animation.mChannels[i];
        first = std::min({first, firstTickOf(c.mPositionKeys, c.mNumPositionKeys),
                          firstTickOf(c.mRotationKeys, c.mNumRotationKeys),
                          firstTickOf(c.mScalingKeys, c.mNumScalingKeys)});
    }
    return first;
}

}  // namespace

void AssimpAnimations::readClips() {
    for (unsigned i = 0; i < file_.mNumAnimations; ++i) readClip(*file_.mAnimations[i], i);
    nodeMoves_ = nodesThatMove(scene_);
}

void AssimpAnimations::readClip(const aiAnimation& animation, std::size_t number) {
    Clip clip{.name = uniqueName(names_, animation.mName.C_Str(), "clip", number)};
    const bool hasRate =
        animation.mTicksPerSecond > 0.0 && std::isfinite(animation.mTicksPerSecond);
    const double ticksPerSecond = hasRate ? animation.mTicksPerSecond : kTicksPerSecond;
    const double firstTick = firstTickOf(animation);
    movedByClip_.clear();
    int dropped = 0;
    for (unsigned i = 0; i < animation.mNumChannels; ++i) {
        dropped += addTracks(*animation.mChannels[i], ticksPerSecond, firstTick, clip);
    }
    if (const auto morphs = animation.mNumMeshChannels + animation.mNumMorphMeshChannels) {
        scene_.warnings.push_back({"morphAnimation", clip.name,
                                   "morph targets of this format are not read; the meshes keep "
                                   "their shape",
                                   morphs});
    }
    addClip(scene_, std::move(clip), static_cast<std::uint64_t>(dropped));
}

int AssimpAnimations::addTracks(const aiNodeAnim& channel, double ticksPerSecond, double firstTick,
                                Clip& clip) {
    const Index node = nodeOf(channel.mNodeName);
    if (node == kNone) return 1;
    const Transform rest = transformOf(scene_.nodes[node].parentFromLocal);
    const double factor = node == 0 ? metresPerUnit_ : 1.0;
    const auto make = [&](AnimatedProperty property, const auto* keys, unsigned count, double by) {
        return trackOf(property, std::span(keys, count), ticksPerSecond, firstTick, by);
    };
    std::array tracks{
        make(AnimatedProperty::translation, channel.mPositionKeys, channel.mNumPositionKeys,
             factor),
        make(AnimatedProperty::rotation, channel.mRotationKeys, channel.mNumRotationKeys, 1.0),
        make(AnimatedProperty::scale, channel.mScalingKeys, channel.mNumScalingKeys, factor)};
    int dropped = 0;
    for (Track& track : tracks) {
        if (track.times.empty() || isConstantRest(track, rest)) continue;
        const bool valid = movedByClip_.insert({track.property, node}).second && isValid(track, 1);
        if (valid) track.target = movingNode(node, rest);
        if (valid && track.target != kNone) {
            clip.tracks.push_back(std::move(track));
        } else {
            ++dropped;
        }
    }
    return dropped;
}

Index AssimpAnimations::nodeOf(const aiString& name) const {
    const auto found = nodeNamed_.find(name.C_Str());
    return found == nodeNamed_.end() ? kNone : found->second;
}

Index AssimpAnimations::movingNode(Index node, const Transform& rest) {
    if (const auto known = movingAt_.find(node); known != movingAt_.end()) return known->second;
    const Index added = addMovingNode(scene_, node, rest);
    if (added != kNone) movingAt_[node] = added;
    return added;
}

bool AssimpAnimations::moves(const aiMesh& mesh) const {
    for (unsigned i = 0; i < mesh.mNumBones; ++i) {
        const Index node = nodeOf(mesh.mBones[i]->mName);
        if (node != kNone && nodeMoves_[node]) return true;
    }
    return false;
}

Index AssimpAnimations::addSkin(const aiMesh& from) {
    Skin skin;
    Index staticNode = kNone;  // in place of bones that are not nodes
    for (unsigned i = 0; i < from.mNumBones; ++i) {
        const aiBone& bone = *from.mBones[i];
        Index node = nodeOf(bone.mName);
        if (node == kNone) {
            if (staticNode == kNone) staticNode = addNode(scene_, "");
            node = staticNode;
        }
        const glm::dmat4 jointFromMesh = matrixOf(bone.mOffsetMatrix);
        skin.joints.push_back(node);
        skin.jointFromMesh.push_back(inReach(jointFromMesh) ? jointFromMesh : glm::dmat4(1.0));
    }
    scene_.skins.push_back(std::move(skin));
    return static_cast<Index>(scene_.skins.size() - 1);
}

void AssimpAnimations::addDeformation(const aiMesh& from,
                                      const std::vector<std::uint32_t>& sources) {
    std::vector<std::vector<Influence>> bonesOf(from.mNumVertices);
    std::size_t maxBones = 1;
    for (unsigned i = 0; i < from.mNumBones; ++i) {
        const aiBone& bone = *from.mBones[i];
        for (unsigned k = 0; k < bone.mNumWeights; ++k) {
            const auto& [vertex, share] = bone.mWeights[k];
            if (vertex >= bonesOf.size() || !(share > 0.0f) || !std::isfinite(share)) continue;
            bonesOf[vertex].push_back({i, share});
            maxBones = std::max(maxBones, bonesOf[vertex].size());
        }
    }
    const std::size_t perVertex = std::min(maxBones, kMaxInfluences);
    for (std::vector<Influence>& bones : bonesOf) {
        std::stable_sort(bones.begin(), bones.end(),
                         [](const Influence& a, const Influence& b) { return a.share > b.share; });
        if (bones.empty()) bones.push_back({0, 1.0f});
        bones.resize(perVertex);
        double sum = 0.0;
        for (const Influence& bone : bones) sum += double{bone.share};
        for (Influence& bone : bones) bone.share = static_cast<float>(bone.share / sum);
    }

    Deformation d{
        .mesh = static_cast<Index>(scene_.meshes.size() - 1),
        .firstVertex = static_cast<std::uint32_t>(scene_.vertices.size() - sources.size()),
        .skin = addSkin(from),
        .perVertex = static_cast<std::uint32_t>(perVertex)};
    for (std::size_t i = 0; i < sources.size(); ++i) {
        const Vertex& v = scene_.vertices[d.firstVertex + i];
        d.base.push_back({v.position, v.normal, v.tangent});
        const std::vector<Influence>& bones = bonesOf[sources[i]];
        d.influences.insert(d.influences.end(), bones.begin(), bones.end());
    }
    scene_.meshes.back().deformation = static_cast<Index>(scene_.deformations.size());
    scene_.deformations.push_back(std::move(d));
}

}  // namespace clerestory
