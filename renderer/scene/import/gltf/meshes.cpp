#include "scene/import/gltf/parts.h"

#include "scene/import/base/imported_scene.h"
#include "scene/import/gltf/draco.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

namespace clerestory {
namespace {

glm::vec3 vec3At(const Numbers& numbers, std::size_t i) {
    const float* v = numbers.at(i);
    return {v[0], v[1], v[2]};
}

// glTF 2.0, 3.7.2.1: without normals triangles are flat and share no vertices. Returns the old
// index of each vertex.
std::vector<std::uint32_t> separateTriangles(MeshDraft& draft) {
    std::vector<Vertex> vertices;
    std::vector<std::uint32_t> sources;
    vertices.reserve(draft.indices.size());
    for (std::uint32_t& i : draft.indices) {
        if (i < draft.vertices.size()) {
            vertices.push_back(draft.vertices[i]);
            sources.push_back(i);
            i = static_cast<std::uint32_t>(vertices.size() - 1);
        } else {
            i = kNone;  // addMesh() reports it
        }
    }
    draft.vertices = std::move(vertices);
    return sources;
}

std::vector<std::uint32_t> counted(std::size_t count) {
    std::vector<std::uint32_t> numbers(count);
    std::iota(numbers.begin(), numbers.end(), 0u);
    return numbers;
}

}  // namespace

GltfMeshes::GltfMeshes(GltfDocument& document, Scene& scene, const ImportLimits& limits)
    : document_(document),
      scene_(scene),
      limits_(limits),
      defaultMaterial_(static_cast<Index>(scene.materials.size() - 1)) {}

const std::vector<Index>& GltfMeshes::meshes(Index gltfMesh) {
    const auto known = known_.find(gltfMesh);
    return known != known_.end() ? known->second : known_[gltfMesh] = posedMeshes(gltfMesh, {});
}

std::vector<Index> GltfMeshes::posedMeshes(Index gltfMesh, const RestPose& pose) {
    return deformingMeshes(gltfMesh, pose, {});
}

std::vector<Index> GltfMeshes::deformingMeshes(Index gltfMesh, const RestPose& pose,
                                               const MeshAnimation& animation) {
    const Json& mesh = document_.item("meshes", gltfMesh);
    const Json& primitives = array(mesh, "primitives");
    std::string name = text(mesh, "name");
    if (name.empty()) {
        name = "mesh " + std::to_string(gltfMesh);
    }
    std::vector<Index> result;
    for (std::size_t i = 0; i < primitives.size(); ++i) {
        const std::string part = primitives.size() > 1 ? " " + std::to_string(i) : "";
        const Index added = add(element(primitives, i, "primitives"), name + part, pose, animation);
        if (added != kNone) {
            result.push_back(added);
        }
    }
    return result;
}

Numbers GltfMeshes::attribute(const Json& attributes, const char* key, std::size_t count,
                              const std::string& name) {
    const Index accessor = indexAt(attributes, key);
    if (accessor == kNone) {
        return {};
    }
    Numbers numbers = document_.floats(accessor);
    const std::string what = key;
    const std::size_t minComponents = what.starts_with("TEXCOORD")                       ? 2
                                      : what == "TANGENT" || what.starts_with("WEIGHTS") ? 4
                                                                                         : 3;
    if (numbers.count() != count || numbers.components < minComponents) {
        scene_.warnings.push_back(
            {"badAttribute", name, what + " does not match the positions and was ignored"});
        return {};
    }
    return numbers;
}

// glTF 2.0, 3.7.2.1: strips, loops and fans become separate triangles and lines.
void GltfMeshes::setIndices(const Json& primitive, std::size_t vertexCount, MeshDraft& draft) {
    enum : std::uint64_t { kPoints, kLines, kLineLoop, kLineStrip, kTriangles, kStrip, kFan };
    const std::uint64_t mode = wholeNumber(primitive, "mode", kTriangles);
    if (mode > kFan) malformed("there is no primitive mode " + std::to_string(mode));
    draft.primitive = mode == kPoints      ? Primitive::points
                      : mode <= kLineStrip ? Primitive::lines
                                           : Primitive::triangles;
    std::vector<std::uint32_t> corners;
    if (const Index accessor = indexAt(primitive, "indices"); accessor != kNone) {
        corners = document_.integers(accessor);
    } else {
        corners = counted(vertexCount);
    }
    const bool isList = mode == kPoints || mode == kLines || mode == kTriangles;
    countPrimitives(primitives_,
                    isList ? corners.size() / indicesPer(draft.primitive) : corners.size(),
                    limits_);
    if (isList) {
        draft.indices = std::move(corners);
        return;
    }
    std::vector<std::uint32_t>& list = draft.indices;
    if (draft.primitive == Primitive::lines) {
        for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
            list.insert(list.end(), {corners[i], corners[i + 1]});
        }
        const bool closes = mode == kLineLoop && corners.size() > 2;
        if (closes) list.insert(list.end(), {corners.back(), corners.front()});
        return;
    }
    for (std::size_t i = 0; i + 2 < corners.size(); ++i) {
        const std::size_t odd =
            mode == kStrip ? i % 2 : 0;  // every second triangle has the opposite winding
        const std::size_t first = mode == kFan ? 0 : i;
        list.insert(list.end(), {corners[first], corners[i + 1 + odd], corners[i + 2 - odd]});
    }
}

Index GltfMeshes::add(const Json& primitive, const std::string& name, const RestPose& pose,
                      const MeshAnimation& animation) {
    const Json& attributes = object(primitive, "attributes");
    const Index positionAccessor = indexAt(attributes, "POSITION");
    if (positionAccessor == kNone) {
        scene_.warnings.push_back({"noPositions", name, "a mesh without positions is not drawn"});
        return kNone;
    }
    decodeDraco(document_, primitive, limits_.maxTriangles - primitives_);
    const Numbers positions = document_.floats(positionAccessor);
    if (positions.components != 3) {
        malformed("positions do not have three components");
    }
    const std::size_t count = positions.count();
    MeshDraft draft;
    draft.name = name;
    setIndices(primitive, count, draft);
    if (draft.indices.empty()) return kNone;
    const Numbers normals = attribute(attributes, "NORMAL", count, name);
    const Numbers tangents = attribute(attributes, "TANGENT", count, name);
    const Numbers texCoords0 = attribute(attributes, "TEXCOORD_0", count, name);
    const Numbers texCoords1 = attribute(attributes, "TEXCOORD_1", count, name);
    const Numbers colors = attribute(attributes, "COLOR_0", count, name);

    draft.hasNormals = normals.count() > 0;
    draft.hasTangents = draft.hasNormals && tangents.count() > 0;
    draft.hasTexCoords = texCoords0.count() > 0;
    draft.vertices.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        Vertex& v = draft.vertices[i];
        v.position = vec3At(positions, i);
        if (draft.hasNormals) v.normal = vec3At(normals, i);
        if (draft.hasTangents) v.tangent = {vec3At(tangents, i), tangents.at(i)[3]};
        if (draft.hasTexCoords) v.texCoord0 = {texCoords0.at(i)[0], texCoords0.at(i)[1]};
        if (texCoords1.count() > 0) v.texCoord1 = {texCoords1.at(i)[0], texCoords1.at(i)[1]};
        if (colors.count() > 0) {
            v.color = {vec3At(colors, i), colors.components > 3 ? colors.at(i)[3] : 1.0f};
        }
    }
    morph(primitive, pose, draft);
    skin(attributes, pose, draft);
    const bool flatNormals = draft.primitive == Primitive::triangles && !draft.hasNormals;
    std::vector<std::uint32_t> fileVertexOf =
        flatNormals ? separateTriangles(draft) : counted(count);
    draft.material = indexAt(primitive, "material");
    if (draft.material == kNone) {
        draft.material = defaultMaterial_;
    } else if (draft.material >= defaultMaterial_) {
        malformed("there is no material with index " + std::to_string(draft.material));
    }
    if (!animation.any()) {
        const Index mesh = addMesh(scene_, std::move(draft));
        addVariants(primitive, mesh);
        return mesh;
    }
    draft.deforms = true;
    std::vector<std::uint32_t> sources;
    const Index mesh = addMesh(scene_, std::move(draft), sources);
    if (mesh == kNone) return kNone;
    addVariants(primitive, mesh);
    for (std::uint32_t& source : sources) source = fileVertexOf[source];
    addDeformation(primitive, count, sources, animation, flatNormals);
    return mesh;
}

// A mesh of several nodes is added once for each pose; its choices are too.
void GltfMeshes::addVariants(const Json& primitive, Index mesh) {
    const Json* choices = extension(primitive, "KHR_materials_variants");
    if (!choices || mesh == kNone) return;
    for (const Json& mapping : array(*choices, "mappings")) {
        const Index material = indexAt(mapping, "material");
        if (material >= defaultMaterial_) malformed("a variant has no such material");
        for (const Index variant : indexList(mapping, "variants")) {
            if (variant >= scene_.variants.size()) malformed("a mesh has no such variant");
            auto& list = scene_.variants[variant].choices;
            if (list.empty() || list.back().mesh != mesh) list.push_back({mesh, material});
        }
    }
}

// For the last mesh of the scene.
void GltfMeshes::addDeformation(const Json& primitive, std::size_t fileVertices,
                                const std::vector<std::uint32_t>& fileVertexOf,
                                const MeshAnimation& animation, bool flatNormals) {
    const std::size_t count = fileVertexOf.size();
    Deformation d{.mesh = static_cast<Index>(scene_.meshes.size() - 1),
                  .firstVertex = static_cast<std::uint32_t>(scene_.vertices.size() - count),
                  .skin = animation.skin,
                  .weights = animation.weights,
                  .flatNormals = flatNormals};
    for (std::size_t i = 0; i < count; ++i) {
        const Vertex& v = scene_.vertices[d.firstVertex + i];
        d.base.push_back({v.position, v.normal, v.tangent});
    }
    if (d.skin != kNone) {
        addInfluences(object(primitive, "attributes"), fileVertices, fileVertexOf, d);
    }
    if (d.weights != kNone) addTargets(primitive, fileVertices, fileVertexOf, d);
    scene_.meshes.back().deformation = static_cast<Index>(scene_.deformations.size());
    scene_.deformations.push_back(std::move(d));
}

std::vector<GltfMeshes::InfluenceSet> GltfMeshes::influenceSets(const Json& attributes,
                                                                std::size_t vertices,
                                                                const std::string& name) {
    std::vector<InfluenceSet> sets;
    for (const char* number : {"0", "1"}) {
        const Index accessor = indexAt(attributes, (std::string("JOINTS_") + number).c_str());
        if (accessor == kNone) break;
        const std::string shares = std::string("WEIGHTS_") + number;
        InfluenceSet set{attribute(attributes, shares.c_str(), vertices, name),
                         document_.integers(accessor)};
        if (set.shares.components != 4 || set.joints.size() != 4 * vertices) break;
        sets.push_back(std::move(set));
    }
    if (sets.empty()) {
        scene_.warnings.push_back(
            {"badAttribute", name,
             "joints and weights do not match; the first joint moves all vertices"});
    }
    return sets;
}

void GltfMeshes::addInfluences(const Json& attributes, std::size_t fileVertices,
                               const std::vector<std::uint32_t>& fileVertexOf, Deformation& d) {
    const std::size_t jointCount = scene_.skins[d.skin].joints.size();
    const std::vector<InfluenceSet> sets =
        influenceSets(attributes, fileVertices, scene_.meshes.back().name);
    d.perVertex = 4 * static_cast<std::uint32_t>(std::max<std::size_t>(1, sets.size()));
    for (const std::uint32_t v : fileVertexOf) {
        const std::size_t first = d.influences.size();
        double sum = 0.0;
        for (const InfluenceSet& set : sets) {
            for (std::size_t k = 0; k < 4; ++k) {
                const std::uint32_t joint = set.joints[4 * v + k];
                const float share = set.shares.at(v)[k];
                const bool counts = share > 0.0f && std::isfinite(share) && joint < jointCount;
                d.influences.push_back(counts ? Influence{joint, share} : Influence{});
                sum += counts ? double{share} : 0.0;
            }
        }
        d.influences.resize(first + d.perVertex);
        if (!(sum > 0.0)) d.influences[first] = {0, 1.0f};
        for (std::size_t k = first; sum > 0.0 && k < d.influences.size(); ++k) {
            d.influences[k].share = static_cast<float>(d.influences[k].share / sum);
        }
    }
}

void GltfMeshes::addTargets(const Json& primitive, std::size_t fileVertices,
                            const std::vector<std::uint32_t>& fileVertexOf, Deformation& d) {
    const Json& targets = array(primitive, "targets");
    const std::string& name = scene_.meshes.back().name;
    const std::size_t maxTargets = scene_.morphWeights[d.weights].rest.size();
    d.firstDelta.push_back(0);
    for (std::size_t t = 0; t < std::min(targets.size(), maxTargets); ++t) {
        const Json& target = element(targets, t, "targets");
        const Numbers positions = attribute(target, "POSITION", fileVertices, name);
        const Numbers normals = attribute(target, "NORMAL", fileVertices, name);
        const Numbers tangents = tangentsOf(target, fileVertices);
        const auto at = [](const Numbers& from, std::size_t i) {
            const glm::vec3 v = from.count() > 0 ? vec3At(from, i) : glm::vec3(0.0f);
            const bool inRange =
                std::abs(v.x) <= kMaxKey && std::abs(v.y) <= kMaxKey && std::abs(v.z) <= kMaxKey;
            return inRange ? v : glm::vec3(0.0f);
        };
        for (std::uint32_t i = 0; i < fileVertexOf.size(); ++i) {
            const std::uint32_t v = fileVertexOf[i];
            const MorphDelta delta{i, at(positions, v), at(normals, v), at(tangents, v)};
            const glm::vec3 none(0.0f);
            if (delta.position != none || delta.normal != none || delta.tangent != none) {
                d.deltas.push_back(delta);
            }
        }
        d.firstDelta.push_back(static_cast<std::uint32_t>(d.deltas.size()));
    }
}

// They have three components: the handedness is not morphed.
Numbers GltfMeshes::tangentsOf(const Json& target, std::size_t vertices) {
    const Index accessor = indexAt(target, "TANGENT");
    Numbers tangents = accessor == kNone ? Numbers{} : document_.floats(accessor);
    if (tangents.components != 3 || tangents.count() != vertices) return {};
    return tangents;
}

void GltfMeshes::morph(const Json& primitive, const RestPose& pose, MeshDraft& draft) {
    const Json& targets = array(primitive, "targets");
    for (std::size_t t = 0; t < std::min(targets.size(), pose.morphWeights.size()); ++t) {
        const auto weight = static_cast<float>(pose.morphWeights[t]);
        if (weight == 0.0f) {
            continue;
        }
        const Json& target = element(targets, t, "targets");
        const std::size_t count = draft.vertices.size();
        const Numbers positions = attribute(target, "POSITION", count, draft.name);
        const Numbers normals = attribute(target, "NORMAL", count, draft.name);
        const Numbers tangents = tangentsOf(target, count);
        for (std::size_t i = 0; i < count; ++i) {
            Vertex& v = draft.vertices[i];
            if (positions.count() > 0) v.position += weight * vec3At(positions, i);
            if (normals.count() > 0) v.normal += weight * vec3At(normals, i);
            if (tangents.count() > 0) v.tangent += weight * glm::vec4(vec3At(tangents, i), 0.0f);
        }
    }
    if (draft.hasNormals && !pose.morphWeights.empty()) {
        for (Vertex& v : draft.vertices) {
            const float length = glm::length(v.normal);
            v.normal =
                length > 0.0f ? v.normal / length : glm::vec3(0.0f);  // addMesh() replaces zero
        }
    }
}

// Linear blend skinning in the rest pose: glTF 2.0, 3.7.3.
void GltfMeshes::skin(const Json& attributes, const RestPose& pose, MeshDraft& draft) {
    if (pose.fromBind.empty()) {
        return;
    }
    const std::size_t count = draft.vertices.size();
    const std::vector<InfluenceSet> sets = influenceSets(attributes, count, draft.name);
    for (std::size_t i = 0; i < count; ++i) {
        glm::dmat4 fromBind(0.0);
        double sum = 0.0;
        for (const InfluenceSet& set : sets) {
            for (std::size_t k = 0; k < 4; ++k) {
                const std::uint32_t joint = set.joints[4 * i + k];
                const auto weight = static_cast<double>(set.shares.at(i)[k]);
                if (weight > 0.0 && joint < pose.fromBind.size()) {
                    fromBind += weight * pose.fromBind[joint];
                    sum += weight;
                }
            }
        }
        fromBind = sum > 0.0 ? fromBind / sum : pose.fromBind.front();
        Vertex& v = draft.vertices[i];
        v.position = glm::vec3(fromBind * glm::dvec4(glm::dvec3(v.position), 1.0));
        const glm::dmat3 linear(fromBind);
        // The cofactor matrix: the inverse transpose times the determinant.
        const glm::dmat3 cofactor(glm::cross(linear[1], linear[2]),
                                  glm::cross(linear[2], linear[0]),
                                  glm::cross(linear[0], linear[1]));
        const auto unit = [](const glm::dvec3& direction) {
            const double length = glm::length(direction);
            return length > 0.0 ? glm::vec3(direction / length) : glm::vec3(0.0f);
        };
        v.normal = unit(cofactor * glm::dvec3(v.normal));
        v.tangent = {unit(linear * glm::dvec3(glm::vec3(v.tangent))), v.tangent.w};
    }
}

}  // namespace clerestory
