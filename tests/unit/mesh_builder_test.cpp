// Repair of arbitrary triangles: difficult cases, a named row each.
#include "scene/mesh_builder.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <limits>
#include <map>

namespace clerestory::test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// A square of two triangles in the plane z = 0, counter-clockwise from +Z.
MeshDraft square(float size = 1.0f) {
    MeshDraft draft{.name = "square"};
    for (const auto& [x, y] : {std::pair(0.0f, 0.0f), {1.0f, 0.0f}, {1.0f, 1.0f}, {0.0f, 1.0f}}) {
        Vertex v;
        v.position = size * glm::vec3(x, y, 0.0f);
        v.texCoord0 = {x, 1.0f - y};  // v grows downwards: the picture stands upright
        draft.vertices.push_back(v);
    }
    draft.indices = {0, 1, 2, 0, 2, 3};
    draft.hasTexCoords = true;
    return draft;
}

Scene sceneOf(const MeshDraft& draft) {
    Scene scene;
    scene.materials.emplace_back();
    addMesh(scene, draft);
    return scene;
}

struct DamagedMesh {
    const char* name;
    std::function<void(MeshDraft&)> spoil;
    const char* warning;  // its code, or null
    std::uint32_t triangles;
};

class MeshRepair : public testing::TestWithParam<DamagedMesh> {};

TEST_P(MeshRepair, RepairsTheMeshAndCountsRepairs) {
    MeshDraft draft = square();
    GetParam().spoil(draft);
    const Scene scene = sceneOf(draft);
    EXPECT_THAT(sceneProblems(scene), testing::IsEmpty());
    EXPECT_EQ(scene.meshes.empty() ? 0u : scene.meshes[0].primitives, GetParam().triangles);
    if (GetParam().warning) {
        EXPECT_THAT(scene.warnings,
                    testing::Contains(testing::Field(&ImportWarning::code, GetParam().warning)));
    } else {
        EXPECT_THAT(scene.warnings, testing::IsEmpty());
    }
    for (const Vertex& v : scene.vertices) {
        EXPECT_NEAR(glm::length(v.normal), 1.0f, 1e-5f);
        EXPECT_NEAR(glm::length(glm::vec3(v.tangent)), 1.0f, 1e-5f);
        EXPECT_NEAR(glm::dot(v.normal, glm::vec3(v.tangent)), 0.0f, 1e-5f);
    }
}

INSTANTIATE_TEST_SUITE_P(
    HardCases, MeshRepair,
    testing::Values(
        DamagedMesh{"nothingWrong", [](MeshDraft&) {}, nullptr, 2},
        DamagedMesh{"nanVertex", [](MeshDraft& d) { d.vertices[3].position.y = kNan; },
                    "nonFiniteVertices", 1},
        DamagedMesh{"infiniteVertex", [](MeshDraft& d) { d.vertices[1].position.x = INFINITY; },
                    "nonFiniteVertices", 1},
        DamagedMesh{"indexOutOfRange", [](MeshDraft& d) { d.indices[5] = 4000000000u; },
                    "indexOutOfRange", 1},
        DamagedMesh{"halfATriangle", [](MeshDraft& d) { d.indices.pop_back(); }, nullptr, 1},
        DamagedMesh{"sameVertexTwice", [](MeshDraft& d) { d.indices[4] = 0; },
                    "degenerateTriangles", 1},
        DamagedMesh{"collinear",
                    [](MeshDraft& d) {
                        d.vertices[3].position = {0.5f, 0.5f, 0};
                    },
                    "degenerateTriangles", 1},
        DamagedMesh{"nothingLeft", [](MeshDraft& d) { d.indices.clear(); }, "emptyMesh", 0},
        DamagedMesh{"tiny", [](MeshDraft& d) { d = square(1e-15f); }, nullptr, 2},
        DamagedMesh{"huge", [](MeshDraft& d) { d = square(1e15f); }, nullptr, 2},
        DamagedMesh{"nanNormals",
                    [](MeshDraft& d) {
                        d.hasNormals = true;
                        d.vertices[0].normal = glm::vec3(kNan);
                    },
                    "badNormals", 2},
        DamagedMesh{"zeroNormals",
                    [](MeshDraft& d) {
                        d.hasNormals = true;
                        for (Vertex& v : d.vertices) v.normal = glm::vec3(0.0f);
                    },
                    "badNormals", 2},
        DamagedMesh{"longNormals",
                    [](MeshDraft& d) {
                        d.hasNormals = true;
                        for (Vertex& v : d.vertices) v.normal = glm::vec3(0, 0, 100);
                    },
                    nullptr, 2},
        DamagedMesh{"nanTexCoord", [](MeshDraft& d) { d.vertices[2].texCoord0.x = kNan; },
                    "badAttributes", 2},
        DamagedMesh{"oneTexCoord",
                    [](MeshDraft& d) {
                        for (Vertex& v : d.vertices) v.texCoord0 = {0, 0};
                    },
                    nullptr, 2},
        DamagedMesh{"nanTangents",
                    [](MeshDraft& d) {
                        d.hasTangents = true;
                        for (Vertex& v : d.vertices) v.tangent = glm::vec4(kNan);
                    },
                    nullptr, 2},
        DamagedMesh{"tangentAlongNormal",
                    [](MeshDraft& d) {
                        d.hasTangents = true;
                        for (Vertex& v : d.vertices) v.tangent = glm::vec4(0, 0, 1, 1);
                    },
                    nullptr, 2},
        DamagedMesh{"unusedVertex",
                    [](MeshDraft& d) {
                        d.vertices.emplace_back();
                        d.vertices.back().position.x = kNan;
                    },
                    nullptr, 2}),
    [](const auto& row) { return row.param.name; });

TEST(MeshBuilder, NormalsFollowWindingAndTangentsFollowTexture) {
    const Scene scene = sceneOf(square());
    for (const Vertex& v : scene.vertices) {
        EXPECT_EQ(v.normal, glm::vec3(0, 0, 1));
        EXPECT_EQ(v.tangent, glm::vec4(1, 0, 0, 1));
    }
    MeshDraft mirrored = square();
    for (Vertex& v : mirrored.vertices) v.texCoord0.x = -v.texCoord0.x;
    EXPECT_EQ(sceneOf(mirrored).vertices[0].tangent, glm::vec4(-1, 0, 0, -1));
}

// The tangent points to where the normal map's u increases.
TEST(MeshBuilder, TangentsFollowTheTransformOfTheNormalTexture) {
    const auto tangentWith = [](const TextureSlot& slot) {
        Scene scene;
        scene.materials.push_back({.normalTexture = slot});
        MeshDraft draft = square();
        draft.material = 0;
        for (Vertex& v : draft.vertices) v.texCoord1 = {v.texCoord0.y, v.texCoord0.x};
        addMesh(scene, draft);
        return scene.vertices[0].tangent;
    };
    const auto near = [](const glm::vec4& a, const glm::vec4& b) {
        return glm::distance(a, b) < 1e-6f;
    };
    constexpr float kQuarter = 1.57079633f;
    EXPECT_TRUE(near(tangentWith({.offset = {5, 7}, .scale = {3, 2}}), {1, 0, 0, 1}));
    // u' = v: the texture coordinate that increases downwards.
    EXPECT_TRUE(near(tangentWith({.rotation = kQuarter}), {0, -1, 0, 1}));
    EXPECT_TRUE(near(tangentWith({.scale = {-1, 1}}), {-1, 0, 0, -1}));
    EXPECT_TRUE(near(tangentWith({.texCoord = 1}), {0, -1, 0, -1}));
}

// A bumpy sheet of n x n squares.
MeshDraft sheet(int n) {
    MeshDraft draft{.name = "sheet"};
    for (int y = 0; y <= n; ++y) {
        for (int x = 0; x <= n; ++x) {
            Vertex v;
            v.position = {x, std::sin(0.3f * static_cast<float>(x * y)), y};
            draft.vertices.push_back(v);
        }
    }
    for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x) {
            const auto a = static_cast<std::uint32_t>(y * (n + 1) + x);
            const auto b = a + static_cast<std::uint32_t>(n) + 1;
            for (const std::uint32_t i : {a, b, a + 1, b, b + 1, a + 1}) draft.indices.push_back(i);
        }
    }
    return draft;
}

TEST(Clusters, ContainEachTriangleOnceWithinBoundsAndSize) {
    const MeshDraft draft = sheet(100);
    const Scene scene = sceneOf(draft);
    ASSERT_GT(scene.clusters.size(), 100u * 100u * 2u / kClusterPrimitives);
    std::map<std::array<float, 9>, int> seen;
    for (const Cluster& c : scene.clusters) {
        EXPECT_LE(c.indexCount, 3 * kClusterPrimitives);
        for (std::uint32_t i = c.firstIndex; i < c.firstIndex + c.indexCount; i += 3) {
            std::array<float, 9> key{};
            for (int k = 0; k < 9; ++k)
                key[k] = scene.vertices[scene.indices[i + k / 3]].position[k % 3];
            ++seen[key];
            for (int k = 0; k < 3; ++k) {
                const glm::vec3 p = scene.vertices[scene.indices[i + k]].position;
                EXPECT_TRUE(glm::all(glm::greaterThanEqual(p, c.bounds.min)) &&
                            glm::all(glm::lessThanEqual(p, c.bounds.max)));
            }
        }
    }
    EXPECT_EQ(seen.size(), draft.indices.size() / 3);
    for (const auto& [triangle, count] : seen) EXPECT_EQ(count, 1);
}

TEST(Clusters, AreSpatiallyCompact) {
    const Scene scene = sceneOf(sheet(100));
    for (const Cluster& c : scene.clusters) {
        const glm::vec3 extent = c.bounds.extent();
        EXPECT_LT(extent.x * extent.z, 0.2f * 100.0f * 100.0f);
    }
}

TEST(MeshBuilder, TheSameDraftGivesTheSameScene) {
    Scene a = sceneOf(sheet(70)), b = sceneOf(sheet(70));
    updateContentHash(a);
    updateContentHash(b);
    EXPECT_EQ(a.contentHash, b.contentHash);
}

}  // namespace
}  // namespace clerestory::test
