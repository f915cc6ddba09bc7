// Repairs first, then normals and tangents, then clusters. The mesh is valid after every step.
#include "scene/mesh_builder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>

namespace clerestory {
namespace {

// A triangle, a line or a point.
template <std::size_t N>
struct Shape {
    std::array<std::uint32_t, N> corner;
};
using Triangle = Shape<3>;

template <std::size_t N>
constexpr const char* kShapes = N == 3   ? "triangles"
                                : N == 2 ? "lines"
                                         : "points";

bool finiteVector(const glm::vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// Twice the triangle's area times its unit normal. In double, because float underflows for tiny and
// overflows for huge triangles.
glm::dvec3 areaNormal(const std::vector<Vertex>& vertices, const Triangle& t) {
    const glm::dvec3 a(vertices[t.corner[0]].position), b(vertices[t.corner[1]].position),
        c(vertices[t.corner[2]].position);
    return glm::cross(b - a, c - a);
}

// Independent of scale: a height below 1e-7 of the longest edge gives no normal in float.
bool degenerate(const std::vector<Vertex>& vertices, const Triangle& t) {
    double longest = 0.0;
    for (int i = 0; i < 3; ++i) {
        const glm::dvec3 edge = glm::dvec3(vertices[t.corner[i]].position) -
                                glm::dvec3(vertices[t.corner[(i + 1) % 3]].position);
        longest = std::max(longest, glm::dot(edge, edge));
    }
    return !(glm::length(areaNormal(vertices, t)) > 1e-7 * longest);
}
bool degenerate(const std::vector<Vertex>& vertices, const Shape<2>& line) {
    return vertices[line.corner[0]].position == vertices[line.corner[1]].position;
}
bool degenerate(const std::vector<Vertex>&, const Shape<1>&) {
    return false;
}

glm::vec3 tangentFor(const glm::vec3& n) {
    const glm::vec3 axis = std::abs(n.x) < 0.5f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
    return glm::normalize(axis - glm::dot(axis, n) * n);
}

void warn(Scene& scene, const MeshDraft& draft, const char* code, const std::string& message,
          std::uint64_t count) {
    if (count > 0) scene.warnings.push_back({code, draft.name, message, count});
}

template <std::size_t N>
std::vector<Shape<N>> validShapes(Scene& scene, const MeshDraft& draft) {
    std::vector<Shape<N>> valid;
    valid.reserve(draft.indices.size() / N);
    std::uint64_t outOfRange = 0, nonFinite = 0, flat = 0;
    for (std::size_t i = 0; i + N <= draft.indices.size(); i += N) {
        Shape<N> t;
        for (std::size_t k = 0; k < N; ++k) t.corner[k] = draft.indices[i + k];
        const auto each = [&](auto&& holds) {
            return std::all_of(t.corner.begin(), t.corner.end(), holds);
        };
        if (!each([&](std::uint32_t v) { return v < draft.vertices.size(); }))
            ++outOfRange;
        else if (!each([&](std::uint32_t v) { return finiteVector(draft.vertices[v].position); }))
            ++nonFinite;
        else if (degenerate(draft.vertices, t))
            ++flat;
        else
            valid.push_back(t);
    }
    const std::string shapes = kShapes<N>;
    warn(scene, draft, "indexOutOfRange", shapes + " with an index out of range were removed",
         outOfRange);
    warn(scene, draft, "nonFiniteVertices", shapes + " with a non-finite position were removed",
         nonFinite);
    if (N == 3) {
        warn(scene, draft, "degenerateTriangles", "triangles without area were removed", flat);
    } else {
        warn(scene, draft, "degenerateLines", "lines without length were removed", flat);
    }
    return valid;
}

// Removes unused vertices and keeps the order. Returns the old index of each vertex.
template <std::size_t N>
std::vector<std::uint32_t> compact(std::vector<Vertex>& vertices, std::vector<Shape<N>>& shapes) {
    std::vector<std::uint32_t> sources;
    std::vector<std::uint32_t> newIndex(vertices.size(), kNone);
    for (const Shape<N>& t : shapes) {
        for (const std::uint32_t v : t.corner) newIndex[v] = 0;
    }
    std::uint32_t used = 0;
    for (std::size_t v = 0; v < vertices.size(); ++v) {
        if (newIndex[v] == kNone) continue;
        vertices[used] = vertices[v];
        sources.push_back(static_cast<std::uint32_t>(v));
        newIndex[v] = used++;
    }
    vertices.resize(used);
    for (Shape<N>& t : shapes) {
        for (std::uint32_t& v : t.corner) v = newIndex[v];
    }
    return sources;
}

void makeNormals(Scene& scene, MeshDraft& draft, const std::vector<Triangle>& triangles) {
    std::vector<bool> needsNormal(draft.vertices.size());
    std::uint64_t count = 0;
    for (std::size_t v = 0; v < draft.vertices.size(); ++v) {
        glm::vec3& n = draft.vertices[v].normal;
        const float length = glm::length(n);
        needsNormal[v] =
            !draft.hasNormals || !finiteVector(n) || !(length > 1e-6f) || !std::isfinite(length);
        if (needsNormal[v])
            ++count;
        else
            n /= length;
    }
    if (count == 0) return;
    if (draft.hasNormals) {
        warn(scene, draft, "badNormals", "normals of length zero or not finite were recomputed",
             count);
    }
    std::vector<glm::dvec3> sums(draft.vertices.size(), glm::dvec3(0.0));
    for (const Triangle& t : triangles) {
        const glm::dvec3 n = areaNormal(draft.vertices, t);
        for (const std::uint32_t v : t.corner) sums[v] += n;
    }
    // Opposite triangles can cancel at a vertex; then the last one is used.
    std::vector<glm::dvec3> fallback(draft.vertices.size(), glm::dvec3(0, 0, 1));
    for (const Triangle& t : triangles) {
        for (const std::uint32_t v : t.corner) fallback[v] = areaNormal(draft.vertices, t);
    }
    for (std::size_t v = 0; v < draft.vertices.size(); ++v) {
        if (!needsNormal[v]) continue;
        const bool cancelled = !(glm::length(sums[v]) > 1e-6 * glm::length(fallback[v]));
        draft.vertices[v].normal = glm::vec3(glm::normalize(cancelled ? fallback[v] : sums[v]));
    }
}

// Lines and points: normals cannot be computed from them.
void mendNormals(Scene& scene, MeshDraft& draft) {
    std::uint64_t count = 0;
    for (Vertex& v : draft.vertices) {
        const float length = glm::length(v.normal);
        const bool valid = draft.hasNormals && std::isfinite(length) && length > 1e-6f;
        if (draft.hasNormals && !valid) ++count;
        v.normal = valid ? v.normal / length : Vertex{}.normal;
    }
    warn(scene, draft, "badNormals", "normals of length zero or not finite were replaced", count);
}

// Along the axes of the texture as the slot maps it (KHR_texture_transform without its offset).
glm::dvec2 texCoordOf(const Vertex& vertex, const TextureSlot& slot) {
    const glm::dvec2 scaled = glm::dvec2(slot.texCoord == 1 ? vertex.texCoord1 : vertex.texCoord0) *
                              glm::dvec2(slot.scale);
    const double cosine = std::cos(slot.rotation), sine = std::sin(slot.rotation);
    return {cosine * scaled.x + sine * scaled.y, cosine * scaled.y - sine * scaled.x};
}

void makeTangents(MeshDraft& draft, const std::vector<Triangle>& triangles,
                  const TextureSlot& slot) {
    std::vector<glm::dvec3> along(draft.vertices.size(), glm::dvec3(0.0)), across(along);
    if (!draft.hasTangents && draft.hasTexCoords) {
        for (const Triangle& t : triangles) {
            const Vertex &a = draft.vertices[t.corner[0]], &b = draft.vertices[t.corner[1]],
                         &c = draft.vertices[t.corner[2]];
            const glm::dvec3 e1(b.position - a.position), e2(c.position - a.position);
            const glm::dvec2 ta = texCoordOf(a, slot);
            const glm::dvec2 d1 = texCoordOf(b, slot) - ta, d2 = texCoordOf(c, slot) - ta;
            // Weighted by area in texture space; the sign of the determinant is the handedness.
            const double sign = d1.x * d2.y - d2.x * d1.y < 0.0 ? -1.0 : 1.0;
            for (const std::uint32_t v : t.corner) {
                along[v] += sign * (d2.y * e1 - d1.y * e2);
                across[v] += sign * (d1.x * e2 - d2.x * e1);
            }
        }
    }
    for (std::size_t v = 0; v < draft.vertices.size(); ++v) {
        Vertex& vertex = draft.vertices[v];
        glm::vec3 t = draft.hasTangents ? glm::vec3(vertex.tangent) : glm::vec3(along[v]);
        // v increases downwards, and green in a normal map points up (glTF 2.0, 3.9.3).
        const float side = draft.hasTangents
                               ? vertex.tangent.w
                               : -static_cast<float>(glm::dot(
                                     glm::cross(glm::dvec3(vertex.normal), along[v]), across[v]));
        if (finiteVector(t)) t = glm::length(t) > 0.0f ? t / glm::length(t) : t;
        t -= glm::dot(t, vertex.normal) * vertex.normal;
        const float length = glm::length(t);
        t = std::isfinite(length) && length > 1e-4f ? t / length : tangentFor(vertex.normal);
        vertex.tangent = glm::vec4(t, side < 0.0f ? -1.0f : 1.0f);
    }
}

void mendAttributes(Scene& scene, MeshDraft& draft) {
    std::uint64_t repaired = 0;
    const auto mend = [&](float& value, float neutral) {
        if (!std::isfinite(value)) {
            value = neutral;
            ++repaired;
        }
    };
    for (Vertex& v : draft.vertices) {
        for (int i = 0; i < 2; ++i) {
            mend(v.texCoord0[i], 0.0f);
            mend(v.texCoord1[i], 0.0f);
        }
        for (int i = 0; i < 4; ++i) mend(v.color[i], 1.0f);
    }
    warn(scene, draft, "badAttributes", "non-finite texture coordinates and colours were replaced",
         repaired);
}

template <std::size_t N>
Bounds boundsOf(const std::vector<Vertex>& vertices, const Shape<N>* first, const Shape<N>* last) {
    Bounds bounds;
    for (const Shape<N>* t = first; t != last; ++t) {
        for (const std::uint32_t v : t->corner) bounds.add(vertices[v].position);
    }
    return bounds;
}

// Splits along the longest axis of the shapes' centres until the clusters are small enough.
template <std::size_t N>
void cut(Scene& scene, const std::vector<Vertex>& vertices, Shape<N>* first, Shape<N>* last,
         std::uint32_t firstVertex) {
    const auto count = static_cast<std::uint32_t>(last - first);
    const auto center = [&](const Shape<N>& t) {
        glm::vec3 sum(0.0f);
        for (const std::uint32_t v : t.corner) sum += vertices[v].position / float{N};
        return sum;
    };
    if (count > kClusterPrimitives) {
        Bounds centers;
        for (const Shape<N>* t = first; t != last; ++t) centers.add(center(*t));
        const glm::vec3 extent = centers.extent();
        const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0
                         : extent.y >= extent.z                       ? 1
                                                                      : 2;
        Shape<N>* middle = first + count / 2;
        // A total order, so that the split is the same with every standard library.
        std::nth_element(first, middle, last, [&](const Shape<N>& a, const Shape<N>& b) {
            const float ca = center(a)[axis], cb = center(b)[axis];
            return ca != cb ? ca < cb : a.corner < b.corner;
        });
        cut(scene, vertices, first, middle, firstVertex);
        cut(scene, vertices, middle, last, firstVertex);
        return;
    }
    std::sort(first, last,
              [](const Shape<N>& a, const Shape<N>& b) { return a.corner < b.corner; });
    scene.clusters.push_back({static_cast<std::uint32_t>(scene.indices.size()),
                              static_cast<std::uint32_t>(N) * count,
                              boundsOf(vertices, first, last)});
    for (const Shape<N>* t = first; t != last; ++t) {
        for (const std::uint32_t v : t->corner) scene.indices.push_back(firstVertex + v);
    }
}

std::vector<FlatGroup> flatGroupsOf(const std::vector<Vertex>& vertices,
                                    const std::vector<Triangle>& triangles) {
    std::vector<std::array<std::uint32_t, 3>> corners;
    corners.reserve(triangles.size());
    for (const Triangle& t : triangles) corners.push_back(t.corner);
    return flatGroups(vertices, corners);
}

// Flat parts first, largest first, then all others, each in separate clusters.
template <std::size_t N>
void cutIntoParts(Scene& scene, Mesh& mesh, const std::vector<Vertex>& vertices,
                  std::vector<Shape<N>>& shapes, bool deforms) {
    const auto firstVertex = static_cast<std::uint32_t>(scene.vertices.size());
    const auto clusters = [&] { return static_cast<std::uint32_t>(scene.clusters.size()); };
    mesh.firstCluster = clusters();
    mesh.firstFlatPart = static_cast<std::uint32_t>(scene.flatParts.size());
    std::vector<bool> inPart(shapes.size());
    std::vector<Shape<N>> chosen;
    std::vector<FlatGroup> groups;
    if constexpr (N == 3) {
        if (!deforms) groups = flatGroupsOf(vertices, shapes);
    }
    for (const FlatGroup& group : groups) {
        chosen.clear();
        for (const std::uint32_t t : group.triangles) {
            chosen.push_back(shapes[t]);
            inPart[t] = true;
        }
        FlatPart part{.firstCluster = clusters(),
                      .normal = group.plane.normal,
                      .offset = group.plane.offset,
                      .area = group.area,
                      .bounds = boundsOf(vertices, chosen.data(), chosen.data() + chosen.size())};
        cut(scene, vertices, chosen.data(), chosen.data() + chosen.size(), firstVertex);
        part.clusterCount = clusters() - part.firstCluster;
        scene.flatParts.push_back(part);
    }
    mesh.flatPartCount = static_cast<std::uint32_t>(scene.flatParts.size()) - mesh.firstFlatPart;
    chosen.clear();
    for (std::size_t t = 0; t < shapes.size(); ++t) {
        if (!inPart[t]) chosen.push_back(shapes[t]);
    }
    if (!chosen.empty()) {
        cut(scene, vertices, chosen.data(), chosen.data() + chosen.size(), firstVertex);
    }
    mesh.clusterCount = clusters() - mesh.firstCluster;
}

// Orders vertices by first use, so that memory is read sequentially (Sponza with the software
// rasteriser: 3 of 110 ms).
void numberByFirstUse(std::vector<Vertex>& vertices, std::vector<std::uint32_t>& sources,
                      std::span<std::uint32_t> indices, std::uint32_t firstVertex) {
    std::vector<std::uint32_t> newIndex(vertices.size(), kNone);
    std::vector<Vertex> ordered;
    std::vector<std::uint32_t> orderedSources;
    ordered.reserve(vertices.size());
    orderedSources.reserve(vertices.size());
    for (std::uint32_t& index : indices) {
        std::uint32_t& to = newIndex[index - firstVertex];
        if (to == kNone) {
            to = static_cast<std::uint32_t>(ordered.size());
            ordered.push_back(vertices[index - firstVertex]);
            orderedSources.push_back(sources[index - firstVertex]);
        }
        index = firstVertex + to;
    }
    vertices = std::move(ordered);
    sources = std::move(orderedSources);
}

template <std::size_t N>
Index addShapes(Scene& scene, MeshDraft& draft, std::vector<std::uint32_t>& sources) {
    std::vector<Shape<N>> shapes = validShapes<N>(scene, draft);
    if (shapes.empty()) {
        warn(scene, draft, "emptyMesh",
             std::string("the mesh has no valid ") + kShapes<N> + " and was removed", 1);
        return kNone;
    }
    sources = compact(draft.vertices, shapes);
    const TextureSlot bumps = draft.material < scene.materials.size()
                                  ? scene.materials[draft.material].normalTexture
                                  : TextureSlot{};
    Mesh mesh;
    if constexpr (N == 3) {
        makeNormals(scene, draft, shapes);
        makeTangents(draft, shapes, bumps);
        for (const Triangle& t : shapes) {
            mesh.area += 0.5 * glm::length(areaNormal(draft.vertices, t));
        }
    } else {
        mendNormals(scene, draft);
        makeTangents(draft, {}, bumps);
        mesh.lit = draft.hasNormals;
    }
    mendAttributes(scene, draft);

    mesh.name = draft.name;
    mesh.material = draft.material;
    mesh.primitive = draft.primitive;
    mesh.primitives = static_cast<std::uint32_t>(shapes.size());
    mesh.bounds = boundsOf(draft.vertices, shapes.data(), shapes.data() + shapes.size());
    mesh.hasColors = std::any_of(draft.vertices.begin(), draft.vertices.end(),
                                 [](const Vertex& v) { return v.color != glm::vec4(1.0f); });
    const std::size_t firstIndex = scene.indices.size();
    cutIntoParts(scene, mesh, draft.vertices, shapes, draft.deforms);
    numberByFirstUse(draft.vertices, sources, std::span(scene.indices).subspan(firstIndex),
                     static_cast<std::uint32_t>(scene.vertices.size()));
    endTriple(scene.indices);
    scene.vertices.insert(scene.vertices.end(), draft.vertices.begin(), draft.vertices.end());
    scene.meshes.push_back(std::move(mesh));
    return static_cast<Index>(scene.meshes.size() - 1);
}

}  // namespace

void endTriple(std::vector<std::uint32_t>& indices) {
    while (indices.size() % 3 != 0) indices.push_back(std::uint32_t{indices.back()});
}

Index addMesh(Scene& scene, MeshDraft draft) {
    std::vector<std::uint32_t> sources;
    return addMesh(scene, std::move(draft), sources);
}

Index addMesh(Scene& scene, MeshDraft draft, std::vector<std::uint32_t>& sources) {
    switch (draft.primitive) {
        case Primitive::points:
            return addShapes<1>(scene, draft, sources);
        case Primitive::lines:
            return addShapes<2>(scene, draft, sources);
        case Primitive::triangles:
            break;
    }
    return addShapes<3>(scene, draft, sources);
}

void addInstance(Scene& scene, Index node, Index mesh, Index material) {
    scene.instances.push_back(
        {node, mesh, material == kNone ? scene.meshes[mesh].material : material});
}

Index addNode(Scene& scene, std::string name, const glm::dmat4& parentFromLocal, Index parent) {
    scene.nodes.push_back({std::move(name), parent, parentFromLocal});
    return static_cast<Index>(scene.nodes.size() - 1);
}

}  // namespace clerestory
