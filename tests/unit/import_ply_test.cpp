// PLY: normals of meshes that have none.
#include "import_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <tuple>
#include <vector>

namespace clerestory::test {
namespace {

struct Polygons {
    std::vector<glm::dvec3> corners;
    std::vector<std::vector<int>> faces;
};

Scene imported(const Polygons& mesh) {
    std::string text = "ply\nformat ascii 1.0\nelement vertex " +
                       std::to_string(mesh.corners.size()) +
                       "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                       std::to_string(mesh.faces.size()) +
                       "\nproperty list uchar int vertex_indices\nend_header\n";
    for (const glm::dvec3& c : mesh.corners) {
        text += std::to_string(c.x) + ' ' + std::to_string(c.y) + ' ' + std::to_string(c.z) + '\n';
    }
    for (const std::vector<int>& face : mesh.faces) {
        text += std::to_string(face.size());
        for (const int corner : face) text += ' ' + std::to_string(corner);
        text += '\n';
    }
    const TemporaryFolder folder;
    return importScene(folder.write("mesh.ply", text));
}

Polygons cube() {
    Polygons mesh;
    for (int i = 0; i < 8; ++i) mesh.corners.emplace_back(i & 1, i >> 1 & 1, i >> 2);
    mesh.faces = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                  {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    return mesh;
}

// A ball whose first meridian has its vertices twice, as at the seam of a texture.
Polygons ball() {
    constexpr int kAround = 24, kDown = 12;
    Polygons mesh;
    for (int j = 0; j <= kDown; ++j) {
        for (int i = 0; i <= kAround; ++i) {
            const double t = std::numbers::pi * j / kDown;
            const double a = 2.0 * std::numbers::pi * (i % kAround) / kAround;
            mesh.corners.emplace_back(std::sin(t) * std::cos(a), std::cos(t),
                                      std::sin(t) * std::sin(a));
        }
    }
    for (int j = 0; j < kDown; ++j) {
        for (int i = 0; i < kAround; ++i) {
            const int a = j * (kAround + 1) + i, below = a + kAround + 1;
            mesh.faces.push_back({a, a + 1, below + 1, below});
        }
    }
    return mesh;
}

TEST(Ply, ACubeOfEightVerticesHasSharpEdges) {
    const Scene scene = imported(cube());
    std::set<std::tuple<float, float, float>> normals;
    for (const Vertex& v : scene.vertices) {
        normals.emplace(std::round(v.normal.x), std::round(v.normal.y), std::round(v.normal.z));
        const glm::vec3 off = glm::abs(v.normal);
        EXPECT_NEAR(off.x + off.y + off.z, 1.0f, 1e-6f) << "along an axis";
        // Outwards: the corner is on the side of the cube that the normal points to.
        EXPECT_GT(glm::dot(v.normal, v.position - 0.5f), 0.0f);
    }
    EXPECT_EQ(normals.size(), 6u);
    EXPECT_EQ(scene.vertices.size(), 24u);
}

TEST(Ply, ABallIsSmooth) {
    const Scene scene = imported(ball());
    ASSERT_FALSE(scene.vertices.empty());
    for (const Vertex& v : scene.vertices) {
        EXPECT_GT(glm::dot(v.normal, glm::normalize(v.position)), 0.995f)
            << v.position.x << ' ' << v.position.y << ' ' << v.position.z;
    }
}

TEST(Ply, ManyFacesAtOnePointAndFacesWithoutAreaAreAccepted) {
    Polygons fan;
    fan.corners.emplace_back(0, 1, 0);
    constexpr int kFaces = 5000;
    for (int i = 0; i < kFaces; ++i) {
        const double a = 2.0 * std::numbers::pi * i / kFaces;
        fan.corners.emplace_back(std::cos(a), 0, std::sin(a));
        fan.faces.push_back({0, 1 + (i + 1) % kFaces, 1 + i});
    }
    fan.faces.push_back({1, 1, 2});
    const Scene scene = imported(fan);
    EXPECT_GT(scene.vertices[scene.indices[0]].normal.y, 0.5f);
    for (const Vertex& v : scene.vertices) EXPECT_NEAR(glm::length(v.normal), 1.0f, 1e-4f);

    Polygons damaged = cube();
    damaged.faces[2][1] = 8;
    EXPECT_THROW(imported(damaged), ImportError);
}

}  // namespace
}  // namespace clerestory::test
