#include "scene/import/assimp/smooth_normals.h"

#include <assimp/mesh.h>
#include <glm/glm.hpp>
#include <glm/trigonometric.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace clerestory {
namespace {

// At the point of a fan of more faces all have the mean, because each would be compared with each.
constexpr std::size_t kMaxFacesAround = 64;
constexpr float kSameNormal = 0.99999f;

glm::vec3 vectorOf(const aiVector3D& v) {
    return {v.x, v.y, v.z};
}

// Whether it has polygons, and only vertices that exist; Assimp refuses others later.
bool isSurface(const aiMesh& mesh) {
    bool hasPolygons = false;
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
        const aiFace& face = mesh.mFaces[f];
        hasPolygons = hasPolygons || face.mNumIndices > 2;
        const auto exists = [&](unsigned vertex) { return vertex < mesh.mNumVertices; };
        if (!std::all_of(face.mIndices, face.mIndices + face.mNumIndices, exists)) return false;
    }
    return hasPolygons;
}

// Twice the area of a polygon along its normal; 0 of a face without area or of damaged numbers.
glm::vec3 areaOf(const aiMesh& mesh, const aiFace& face) {
    glm::dvec3 sum(0.0);
    if (face.mNumIndices < 3) return glm::vec3(0.0f);
    const glm::dvec3 first(vectorOf(mesh.mVertices[face.mIndices[0]]));
    for (unsigned k = 2; k < face.mNumIndices; ++k) {
        sum += glm::cross(glm::dvec3(vectorOf(mesh.mVertices[face.mIndices[k - 1]])) - first,
                          glm::dvec3(vectorOf(mesh.mVertices[face.mIndices[k]])) - first);
    }
    const double length = glm::length(sum);
    return length > 0.0 && length < 1e38 ? glm::vec3(sum) : glm::vec3(0.0f);
}

glm::vec3 unit(const glm::vec3& v) {
    const double length = glm::length(glm::dvec3(v));
    return length > 0.0 ? glm::vec3(glm::dvec3(v) / length) : glm::vec3(0.0f);
}

struct PositionHash {
    std::size_t operator()(const glm::vec3& p) const {
        std::uint64_t h = 1469598103934665603ull;
        for (int k = 0; k < 3; ++k) {
            h = (h ^ std::bit_cast<std::uint32_t>(p[k] + 0.0f)) * 1099511628211ull;  // -0 is 0
        }
        return static_cast<std::size_t>(h ^ (h >> 29));
    }
};

// The faces at each position.
class FacesAround {
public:
    explicit FacesAround(const aiMesh& mesh) : positionOf_(mesh.mNumVertices) {
        std::unordered_map<glm::vec3, std::uint32_t, PositionHash> found;
        for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
            const auto next = static_cast<std::uint32_t>(found.size());
            positionOf_[v] = found.try_emplace(vectorOf(mesh.mVertices[v]), next).first->second;
        }
        first_.assign(found.size() + 1, 0);
        eachCorner(mesh, [&](std::uint32_t, std::uint32_t at) { ++first_[at + 1]; });
        for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
        faces_.resize(first_.back());
        std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
        eachCorner(mesh, [&](std::uint32_t face, std::uint32_t at) { faces_[next[at]++] = face; });
    }
    std::uint32_t positionOf(unsigned vertex) const { return positionOf_[vertex]; }
    const std::uint32_t* begin(unsigned vertex) const {
        return faces_.data() + first_[positionOf_[vertex]];
    }
    const std::uint32_t* end(unsigned vertex) const {
        return faces_.data() + first_[positionOf_[vertex] + 1];
    }

private:
    template <typename Visit>
    void eachCorner(const aiMesh& mesh, const Visit& visit) const {
        for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
            for (unsigned k = 0; k < mesh.mFaces[f].mNumIndices; ++k) {
                visit(f, positionOf_[mesh.mFaces[f].mIndices[k]]);
            }
        }
    }

    std::vector<std::uint32_t> positionOf_, first_, faces_;
};

// `from` is an array of the mesh, or null.
template <typename Value>
void repeat(Value*& from, const std::vector<std::uint32_t>& sources) {
    if (!from) return;
    auto* to = new Value[sources.size()];  // the mesh deletes it
    for (std::size_t i = 0; i < sources.size(); ++i) to[i] = from[sources[i]];
    delete[] from;
    from = to;
}

}  // namespace

void addSmoothNormals(aiMesh& mesh, float creaseDegrees) {
    if (mesh.mNormals || !isSurface(mesh)) return;
    const float least = std::cos(glm::radians(creaseDegrees));
    std::vector<glm::vec3> areas(mesh.mNumFaces), turned(mesh.mNumFaces);
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
        areas[f] = areaOf(mesh, mesh.mFaces[f]);
        turned[f] = unit(areas[f]);
    }
    const FacesAround around(mesh);
    std::unordered_map<std::uint32_t, glm::vec3> meanAt;  // at positions with many faces
    std::vector<std::uint32_t> sources;                   // the mesh's vertex of each new one
    std::vector<glm::vec3> normals;
    constexpr std::uint32_t kNone = ~0u;
    // The new vertices of a vertex as a list.
    std::vector<std::uint32_t> firstOf(mesh.mNumVertices, kNone), next;
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
        for (unsigned k = 0; k < mesh.mFaces[f].mNumIndices; ++k) {
            unsigned& vertex = mesh.mFaces[f].mIndices[k];
            const auto* begin = around.begin(vertex);
            const auto* end = around.end(vertex);
            const bool all = static_cast<std::size_t>(end - begin) > kMaxFacesAround;
            const auto sumWhere = [&](const auto& counts) {
                glm::vec3 sum(0.0f);
                for (const auto* other = begin; other != end; ++other) {
                    if (counts(*other)) sum += areas[*other];
                }
                return sum;
            };
            glm::vec3 normal;
            if (all) {
                const auto [mean, isNew] = meanAt.try_emplace(around.positionOf(vertex));
                if (isNew) mean->second = unit(sumWhere([](std::uint32_t) { return true; }));
                normal = mean->second;
            } else {
                normal = unit(sumWhere([&](std::uint32_t other) {
                    return glm::dot(turned[f], turned[other]) >= least;
                }));
                if (normal == glm::vec3(0.0f)) normal = turned[f];
            }
            if (normal == glm::vec3(0.0f)) normal = {0.0f, 1.0f, 0.0f};  // no face has an area
            std::uint32_t found = firstOf[vertex];
            while (found != kNone && glm::dot(normals[found], normal) < kSameNormal &&
                   normals[found] != normal) {
                found = next[found];
            }
            if (found == kNone) {
                found = static_cast<std::uint32_t>(sources.size());
                sources.push_back(vertex);
                normals.push_back(normal);
                next.push_back(firstOf[vertex]);
                firstOf[vertex] = found;
            }
            vertex = found;
        }
    }
    repeat(mesh.mVertices, sources);
    for (aiColor4D*& colors : mesh.mColors) repeat(colors, sources);
    for (aiVector3D*& coordinates : mesh.mTextureCoords) repeat(coordinates, sources);
    mesh.mNormals = new aiVector3D[sources.size()];
    for (std::size_t i = 0; i < sources.size(); ++i) {
        mesh.mNormals[i] = aiVector3D(normals[i].x, normals[i].y, normals[i].z);
    }
    mesh.mNumVertices = static_cast<unsigned>(sources.size());
}

}  // namespace clerestory
