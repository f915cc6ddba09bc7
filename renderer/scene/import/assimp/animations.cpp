#include "scene/import/assimp/animations.h"

#include "scene/import/assimp/matrix.h"
#include "scene/import/base/clips.h"
#include "scene/mesh_builder.h"

#include <assimp/scene.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace clerestory {
namespace {

// Of files that do not say; 3D Studio's frames.
constexpr double kTicksPerSecond = 30.0;

// Most bones that move one vertex; more are the ones that matter least.
constexpr std::size_t kMaxInfluences = 8;

std::array<double, 3> numbersOf(const aiVector3D& v) {
    return {v.x, v.y, v.z};
}
std::array<double, 4> numbersOf(const aiQuaternion& q) {
    const double length = std::hypot(std::hypot(q.x, q.y), std::hypot(q.z, q.w));
    if (!(length > 0.0 && std::isfinite(length))) return {0.0, 0.0, 0.0, 1.0};
    return {q.x / length, q.y / length, q.z / length, q.w / length};
}

// Keys as a track. factor: on every value.
template <class Key>
Track trackOf(AnimatedProperty moved, std::span<const Key> keys, double ticksPerSecond,
              double firstTick, double factor = 1.0) {
    Track track{.moved = moved};
    for (const Key& key : keys) {
        track.times.push_back(static_cast<float>((key.mTime - firstTick) / ticksPerSecond));
        for (const double value : numbersOf(key.mValue)) {
            track.values.push_back(static_cast<float>(factor * value));
        }
    }
    return track;
}

// Readers give every channel all three kinds of keys; most say only where the node is anyway.
bool staysAtRest(const Track& track, const Transform& rest) {
    const glm::dquat& q = rest.rotation;
    const bool turns = track.moved == AnimatedProperty::rotation;
    const glm::dvec3& v = track.moved == AnimatedProperty::scale ? rest.scale : rest.translation;
    const glm::dvec4 still = turns ? glm::dvec4(q.x, q.y, q.z, q.w) : glm::dvec4(v, 0.0);
    constexpr double kFloats = 1e-6;
    const double near = kFloats * glm::length(still);
    const std::size_t n = track.components();
    for (std::size_t key = 0; key < track.times.size(); ++key) {
        glm::dvec4 value(0.0);
        for (std::size_t i = 0; i < n; ++i) {
            value[static_cast<int>(i)] = double{track.values[n * key + i]};
        }
        // A quaternion and its negative turn alike.
        if (turns && glm::dot(value, still) < 0.0) value = -value;
        if (!(glm::distance(value, still) <= near)) return false;
    }
    return true;
}

template <class Key>
double firstTickOf(const Key* keys, unsigned count) {
    return count > 0 && std::isfinite(keys[0].mTime) ? keys[0].mTime : 0.0;
}

// Where the clip's seconds begin: at 0, or at the first key before it.
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

void AssimpMotion::readClips() {
    for (unsigned i = 0; i < file_.mNumAnimations; ++i) readClip(*file_.mAnimations[i], i);
    nodeMoves_ = nodesThatMove(scene_);
}

void AssimpMotion::readClip(const aiAnimation& animation, std::size_t number) {
    Clip clip{.name = uniqueClipName(names_, animation.mName.C_Str(), number)};
    const bool said = animation.mTicksPerSecond > 0.0 && std::isfinite(animation.mTicksPerSecond);
    const double ticksPerSecond = said ? animation.mTicksPerSecond : kTicksPerSecond;
    const double firstTick = firstTickOf(animation);
    movedByClip_.clear();
    int dropped = 0;
    for (unsigned i = 0; i < animation.mNumChannels; ++i) {
        dropped += addTracks(*animation.mChannels[i], ticksPerSecond, firstTick, clip);
    }
    if (const auto morphs = animation.mNumMeshChannels + animation.mNumMorphMeshChannels) {
        scene_.warnings.push_back({"morphAnimation", clip.name,
                                   "morph targets of this format are not read; what they move "
                                   "keeps its shape",
                                   morphs});
    }
    addClip(scene_, std::move(clip), static_cast<std::uint64_t>(dropped));
}

int AssimpMotion::addTracks(const aiNodeAnim& channel, double ticksPerSecond, double firstTick,
                            Clip& clip) {
    const Index node = nodeOf(channel.mNodeName);
    if (node == kNone) return 1;
    const Transform rest = partsOf(scene_.nodes[node].parentFromLocal);
    const double factor = node == 0 ? metresPerUnit_ : 1.0;
    const auto make = [&](AnimatedProperty moved, const auto* keys, unsigned count, double by) {
        return trackOf(moved, std::span(keys, count), ticksPerSecond, firstTick, by);
    };
    std::array tracks{
        make(AnimatedProperty::translation, channel.mPositionKeys, channel.mNumPositionKeys,
             factor),
        make(AnimatedProperty::rotation, channel.mRotationKeys, channel.mNumRotationKeys, 1.0),
        make(AnimatedProperty::scale, channel.mScalingKeys, channel.mNumScalingKeys, factor)};
    int dropped = 0;
    for (Track& track : tracks) {
        if (track.times.empty() || staysAtRest(track, rest)) continue;
        const bool taken = movedByClip_.insert({track.moved, node}).second && sound(track, 1);
        if (taken) track.target = movingNode(node, rest);
        if (taken && track.target != kNone) {
            clip.tracks.push_back(std::move(track));
        } else {
            ++dropped;
        }
    }
    return dropped;
}

Index AssimpMotion::nodeOf(const aiString& name) const {
    const auto found = nodeNamed_.find(name.C_Str());
    return found == nodeNamed_.end() ? kNone : found->second;
}

Index AssimpMotion::movingNode(Index node, const Transform& rest) {
    if (const auto known = movingAt_.find(node); known != movingAt_.end()) return known->second;
    const Index added = addMovingNode(scene_, node, rest);
    if (added != kNone) movingAt_[node] = added;
    return added;
}

bool AssimpMotion::moves(const aiMesh& mesh) const {
    for (unsigned i = 0; i < mesh.mNumBones; ++i) {
        const Index node = nodeOf(mesh.mBones[i]->mName);
        if (node != kNone && nodeMoves_[node]) return true;
    }
    return false;
}

Index AssimpMotion::addSkin(const aiMesh& from) {
    Skin skin;
    Index still = kNone;  // stands for bones that are no nodes
    for (unsigned i = 0; i < from.mNumBones; ++i) {
        const aiBone& bone = *from.mBones[i];
        Index node = nodeOf(bone.mName);
        if (node == kNone) {
            if (still == kNone) still = addNode(scene_, "");
            node = still;
        }
        const glm::dmat4 jointFromMesh = matrixOf(bone.mOffsetMatrix);
        skin.joints.push_back(node);
        skin.jointFromMesh.push_back(inReach(jointFromMesh) ? jointFromMesh : glm::dmat4(1.0));
    }
    scene_.skins.push_back(std::move(skin));
    return static_cast<Index>(scene_.skins.size() - 1);
}

void AssimpMotion::addDeformation(const aiMesh& from, const std::vector<std::uint32_t>& sources) {
    std::vector<std::vector<Influence>> bonesOf(from.mNumVertices);
    std::size_t most = 1;
    for (unsigned i = 0; i < from.mNumBones; ++i) {
        const aiBone& bone = *from.mBones[i];
        for (unsigned k = 0; k < bone.mNumWeights; ++k) {
            const auto& [vertex, share] = bone.mWeights[k];
            if (vertex >= bonesOf.size() || !(share > 0.0f) || !std::isfinite(share)) continue;
            bonesOf[vertex].push_back({i, share});
            most = std::max(most, bonesOf[vertex].size());
        }
    }
    const std::size_t perVertex = std::min(most, kMaxInfluences);
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
