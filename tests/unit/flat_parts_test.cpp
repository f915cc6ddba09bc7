// Detection of flat parts at any scale and orientation: errata P4 and P5.
#include "scene/mesh_builder.h"

#include <gmock/gmock.h>
#include <glm/gtc/matrix_transform.hpp>

#include <cmath>
#include <functional>
#include <random>
#include <set>

namespace clerestory::test {
namespace {

// A sheet of n x n squares over -1..1, its height given; normals are made by addMesh().
MeshDraft sheet(int n, const std::function<double(double, double)>& height) {
    MeshDraft draft{.name = "sheet"};
    for (int j = 0; j <= n; ++j) {
        for (int i = 0; i <= n; ++i) {
            const double x = 2.0 * i / n - 1.0, y = 2.0 * j / n - 1.0;
            Vertex v;
            v.position = glm::vec3(x, y, height(x, y));
            draft.vertices.push_back(v);
        }
    }
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
            const auto a = static_cast<std::uint32_t>(j * (n + 1) + i);
            const std::uint32_t b = a + static_cast<std::uint32_t>(n) + 1;
            for (const std::uint32_t k : {a, a + 1, b, a + 1, b + 1, b}) draft.indices.push_back(k);
        }
    }
    return draft;
}

MeshDraft flatSheet(int n) {
    return sheet(n, [](double, double) { return 0.0; });
}

// Smooth normals, as a modeller writes them.
MeshDraft ball(double radius, int rows) {
    MeshDraft draft = sheet(rows, [](double, double) { return 0.0; });
    draft.hasNormals = true;
    for (Vertex& v : draft.vertices) {
        const double theta = 1.5707963 * (1.0 + static_cast<double>(v.position.y)),
                     phi = 3.14159265 * (1.0 + static_cast<double>(v.position.x));
        const glm::dvec3 n(std::sin(theta) * std::cos(phi), std::cos(theta),
                           std::sin(theta) * std::sin(phi));
        v.normal = glm::vec3(n);
        v.position = glm::vec3(radius * n);
    }
    return draft;
}

MeshDraft points(std::initializer_list<glm::vec3> positions) {
    MeshDraft draft{.name = "points"};
    for (const glm::vec3& p : positions) {
        draft.vertices.emplace_back();
        draft.vertices.back().position = p;
        draft.indices.push_back(static_cast<std::uint32_t>(draft.indices.size()));
    }
    return draft;
}

void transform(MeshDraft& draft, const glm::dmat4& m) {
    for (Vertex& v : draft.vertices) {
        v.position = glm::vec3(glm::dvec3(m * glm::dvec4(glm::dvec3(v.position), 1.0)));
        v.normal = glm::vec3(glm::normalize(glm::dmat3(m) * glm::dvec3(v.normal)));
    }
}

void addNoise(MeshDraft& draft, double amount) {
    std::mt19937 engine(3);
    std::uniform_real_distribution<double> noise(-amount, amount);
    for (Vertex& v : draft.vertices) {
        v.position.z = static_cast<float>(static_cast<double>(v.position.z) + noise(engine));
    }
}

Scene sceneWith(MeshDraft draft) {
    Scene scene;
    scene.materials.emplace_back();
    addMesh(scene, std::move(draft));
    EXPECT_THAT(sceneProblems(scene), testing::IsEmpty());
    return scene;
}

// One part that holds every triangle.
bool isPlanar(const Scene& scene) {
    if (scene.meshes.empty()) return false;
    const Mesh& mesh = scene.meshes[0];
    return mesh.flatPartCount == 1 && scene.flatParts[0].clusterCount == mesh.clusterCount;
}

struct Shape {
    const char* name;
    std::function<MeshDraft()> draft;
    bool planar;
};
class Flatness : public testing::TestWithParam<Shape> {};

TEST_P(Flatness, IsDetectedAtAnyScaleAndOrientation) {
    std::mt19937 engine(11);
    std::uniform_real_distribution<double> angle(0.0, 6.28);
    std::normal_distribution<double> normal;
    for (int exponent = -4; exponent <= 6; ++exponent) {
        for (int turn = 0; turn < 4; ++turn) {
            MeshDraft draft = GetParam().draft();
            glm::dmat4 m = glm::scale(glm::dmat4(1.0), glm::dvec3(std::pow(10.0, exponent)));
            if (turn > 0) {
                m = m * glm::rotate(glm::dmat4(1.0), angle(engine),
                                    glm::normalize(glm::dvec3(normal(engine), normal(engine),
                                                              normal(engine))));
            }
            transform(draft, m);
            EXPECT_EQ(isPlanar(sceneWith(draft)), GetParam().planar)
                << "scale 1e" << exponent << ", turn " << turn;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(
    P4, Flatness,
    testing::Values(
        Shape{"axisAlignedQuad", [] { return flatSheet(1); }, true},
        Shape{"quadTurnedBy28Degrees",
              [] {
                  MeshDraft draft = flatSheet(1);
                  transform(draft, glm::rotate(glm::dmat4(1.0), glm::radians(28.0), {1, 2, 3}));
                  return draft;
              },
              true},
        Shape{"quadFarAwayWithOneUlpOfNoise",
              [] {
                  MeshDraft draft = flatSheet(1);
                  transform(draft, glm::translate(glm::dmat4(1.0), {0, 0, 1000}));
                  addNoise(draft, std::exp2(-14.0));
                  return draft;
              },
              true},
        Shape{"largeQuadWarpedByABillionth",
              [] {
                  MeshDraft draft =
                      sheet(4, [](double x, double y) { return 1e-9 * std::sin(9 * x + 7 * y); });
                  transform(draft, glm::scale(glm::dmat4(1.0), glm::dvec3(1e6)));
                  return draft;
              },
              true},
        Shape{"fineSheet", [] { return flatSheet(60); }, true},
        Shape{"tinyBall", [] { return ball(4e-6, 24); }, false},
        Shape{"curvedPatch",
              [] {
                  MeshDraft draft =
                      sheet(12, [](double x, double y) { return 0.1 * (x * x + y * y); });
                  transform(draft, glm::scale(glm::dmat4(1.0), glm::dvec3(1e-4)));
                  return draft;
              },
              false},
        Shape{"point",
              [] {
                  return points({{1, 2, 3}, {1, 2, 3}, {1, 2, 3}});
              },
              false},
        Shape{"line",
              [] {
                  return points({{0, 0, 0}, {1, 2, 3}, {2, 4, 6}});
              },
              false},
        Shape{"foldOfTwoDegrees",
              [] { return sheet(2, [](double x, double) { return 0.035 * std::abs(x); }); },
              false}),
    [](const auto& row) { return row.param.name; });

TEST(FlatParts, AFoldHasTwoParts) {
    const Scene scene = sceneWith(sheet(40, [](double x, double) { return x > 0.0 ? x : 0.0; }));
    ASSERT_EQ(scene.flatParts.size(), 2u);
    EXPECT_NEAR(glm::dot(scene.flatParts[0].normal, scene.flatParts[1].normal), std::sqrt(0.5),
                1e-7);
    EXPECT_NEAR(scene.flatParts[0].area, 2.0 * std::sqrt(2.0), 1e-6);
    EXPECT_NEAR(scene.flatParts[1].area, 2.0, 1e-6);
    EXPECT_NEAR(scene.meshes[0].area, 2.0 + 2.0 * std::sqrt(2.0), 1e-6);
}

MeshDraft box(bool shared) {
    MeshDraft draft{.name = "box"};
    for (int axis = 0; axis < 3; ++axis) {
        for (int side = -1; side <= 1; side += 2) {
            const auto first = static_cast<std::uint32_t>(draft.vertices.size());
            for (int i = 0; i < 4; ++i) {
                Vertex v;
                v.position[axis] = static_cast<float>(side);
                v.position[(axis + 1) % 3] = i == 1 || i == 2 ? 1.0f : -1.0f;
                v.position[(axis + 2) % 3] = i >= 2 ? 1.0f : -1.0f;
                draft.vertices.push_back(v);
            }
            for (const std::uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) {
                draft.indices.push_back(first + (side > 0 ? i : 3 - i));
            }
        }
    }
    if (shared) {
        std::vector<Vertex> corners;
        for (std::uint32_t& i : draft.indices) {
            const glm::vec3 p = draft.vertices[i].position;
            std::size_t k = 0;
            while (k < corners.size() && corners[k].position != p) ++k;
            if (k == corners.size()) corners.push_back(draft.vertices[i]);
            i = static_cast<std::uint32_t>(k);
        }
        draft.vertices = corners;
    }
    return draft;
}

TEST(FlatParts, NormalsComeFromTrianglesNotVertices) {  // P5
    MeshDraft smoothed = box(true), absent = box(true), bad = box(true);
    smoothed.hasNormals = bad.hasNormals = true;
    for (Vertex& v : smoothed.vertices) v.normal = glm::normalize(v.position);  // 55 degrees off
    for (Vertex& v : bad.vertices) v.normal = glm::vec3(NAN);
    for (const MeshDraft& draft : {box(false), smoothed, absent, bad}) {
        const Scene scene = sceneWith(draft);
        ASSERT_EQ(scene.flatParts.size(), 6u);
        std::set<std::array<double, 3>> normals;
        for (const FlatPart& p : scene.flatParts) {
            EXPECT_EQ(p.offset, -1.0) << "every face looks outwards";
            EXPECT_EQ(p.area, 4.0);
            EXPECT_EQ(p.clusterCount, 1u);
            normals.insert({p.normal.x, p.normal.y, p.normal.z});
        }
        EXPECT_EQ(normals.size(), 6u);
    }
    MeshDraft tilted = flatSheet(1);
    tilted.hasNormals = true;
    for (Vertex& v : tilted.vertices) v.normal = glm::normalize(glm::vec3(1, 0, 1));
    EXPECT_EQ(sceneWith(tilted).flatParts.at(0).normal, glm::dvec3(0, 0, 1));
}

TEST(FlatParts, WindingDefinesTheFront) {
    MeshDraft turned = flatSheet(3);
    for (std::size_t i = 0; i < turned.indices.size(); i += 3) {
        std::swap(turned.indices[i], turned.indices[i + 1]);
    }
    EXPECT_EQ(sceneWith(flatSheet(3)).flatParts.at(0).normal.z, 1.0);
    EXPECT_EQ(sceneWith(turned).flatParts.at(0).normal.z, -1.0);
}

TEST(FlatParts, CurvedMeshesHaveNone) {
    EXPECT_THAT(sceneWith(ball(1.0, 6)).flatParts, testing::IsEmpty());
    EXPECT_THAT(sceneWith(ball(1.0, 40)).flatParts, testing::IsEmpty());
}

TEST(FlatParts, LieInOnePlaneWithoutTouching) {  // three panes in one wall
    MeshDraft panes;
    for (const double x : {-10.0, 0.0, 30.0}) {
        MeshDraft one = flatSheet(2);
        transform(one, glm::translate(glm::dmat4(1.0), {x, 0, 2}));
        const auto first = static_cast<std::uint32_t>(panes.vertices.size());
        panes.vertices.insert(panes.vertices.end(), one.vertices.begin(), one.vertices.end());
        for (const std::uint32_t i : one.indices) panes.indices.push_back(first + i);
    }
    const Scene scene = sceneWith(panes);
    ASSERT_EQ(scene.flatParts.size(), 1u);
    EXPECT_NEAR(scene.flatParts[0].area, 12.0, 1e-9);
    EXPECT_NEAR(scene.flatParts[0].offset, -2.0, 1e-9);
}

TEST(FlatParts, CloseParallelSheetsAreSeparate) {
    MeshDraft draft = flatSheet(4);
    for (const double z : {1e-3, 100.0}) {  // the far one makes the mesh large
        MeshDraft other = flatSheet(4);
        transform(other, glm::translate(glm::dmat4(1.0), {0, 0, z}));
        const auto first = static_cast<std::uint32_t>(draft.vertices.size());
        draft.vertices.insert(draft.vertices.end(), other.vertices.begin(), other.vertices.end());
        for (const std::uint32_t i : other.indices) draft.indices.push_back(first + i);
    }
    const Scene scene = sceneWith(draft);
    std::multiset<double> offsets;
    for (const FlatPart& p : scene.flatParts) {
        offsets.insert(std::round(-p.offset * 1e6) / 1e6);
        EXPECT_NEAR(p.area, 4.0, 1e-6);
    }
    EXPECT_THAT(offsets, testing::ElementsAre(0.0, 1e-3, 100.0));
}

TEST(FlatParts, ContainExactlyTheirTriangles) {  // a floor round a bumpy hill
    MeshDraft draft = sheet(80, [](double x, double y) {
        return x * x + y * y < 0.5 ? 0.3 + 0.1 * std::cos(9 * x) * std::sin(8 * y) : 0.0;
    });
    const Scene scene = sceneWith(draft);
    ASSERT_EQ(scene.flatParts.size(), 1u);
    const FlatPart& part = scene.flatParts[0];
    const Mesh& mesh = scene.meshes[0];
    EXPECT_EQ(part.firstCluster, mesh.firstCluster);
    EXPECT_GT(part.clusterCount, 1u);
    EXPECT_LT(part.clusterCount, mesh.clusterCount);
    EXPECT_NEAR(part.area, 4.0 - 0.5 * 3.14159, 0.1);
    for (std::uint32_t c = mesh.firstCluster; c < mesh.firstCluster + mesh.clusterCount; ++c) {
        const Cluster& cluster = scene.clusters[c];
        const bool inPart = c < part.firstCluster + part.clusterCount;
        for (std::uint32_t i = 0; i < cluster.indexCount; i += 3) {
            double highest = 0.0;
            for (std::uint32_t k = 0; k < 3; ++k) {
                const auto& p = scene.vertices[scene.indices[cluster.firstIndex + i + k]].position;
                highest = std::max(highest, std::abs(static_cast<double>(p.z)));
            }
            EXPECT_EQ(highest == 0.0, inPart);
        }
    }
}

TEST(FlatParts, TheTwelveLargestAreKept) {
    MeshDraft draft;
    for (int k = 0; k < 20; ++k) {  // a stair of ever smaller steps, in no order
        MeshDraft step = flatSheet(1);
        const double size = 1.0 - 0.03 * ((7 * k) % 20);
        transform(step,
                  glm::scale(glm::translate(glm::dmat4(1.0), {0, 0, 0.3 * k}), glm::dvec3(size)));
        const auto first = static_cast<std::uint32_t>(draft.vertices.size());
        draft.vertices.insert(draft.vertices.end(), step.vertices.begin(), step.vertices.end());
        for (const std::uint32_t i : step.indices) draft.indices.push_back(first + i);
    }
    const Scene scene = sceneWith(draft);
    ASSERT_EQ(scene.flatParts.size(), 12u);
    for (int k = 0; k < 12; ++k) {
        const double size = 1.0 - 0.03 * k;
        EXPECT_NEAR(scene.flatParts[static_cast<std::size_t>(k)].area, 4 * size * size, 1e-5);
    }
}

}  // namespace
}  // namespace clerestory::test
