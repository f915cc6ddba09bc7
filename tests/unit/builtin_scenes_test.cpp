// Shapes are closed and face outwards; built-in scenes are valid, reproducible, and contain what
// their descriptions list.
#include "scene/builtin/builtin_scenes.h"

#include "scene/builtin/modelling.h"

#include <gmock/gmock.h>
#include <glm/gtc/constants.hpp>

#include <array>
#include <map>

namespace clerestory::test {
namespace {

// Six times the volume that the triangles enclose; positive when they face outwards.
double volume(const MeshDraft& mesh) {
    double sum = 0.0;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const auto at = [&](std::size_t k) {
            return glm::dvec3(mesh.vertices[mesh.indices[i + k]].position);
        };
        sum += glm::dot(at(0), glm::cross(at(1), at(2)));
    }
    return sum / 6.0;
}

// Edges, by the places of their ends, that are not walked once in each direction.
int openEdges(const MeshDraft& mesh) {
    using Place = std::array<int, 3>;
    std::map<std::pair<Place, Place>, int> walked;
    const auto place = [&](std::uint32_t v) {
        const glm::vec3 p = glm::round(mesh.vertices[v].position * 1e5f);
        return Place{static_cast<int>(p.x), static_cast<int>(p.y), static_cast<int>(p.z)};
    };
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        for (std::size_t k = 0; k < 3; ++k) {
            const Place a = place(mesh.indices[i + k]), b = place(mesh.indices[i + (k + 1) % 3]);
            if (a < b)
                ++walked[{a, b}];
            else
                --walked[{b, a}];
        }
    }
    int open = 0;
    for (const auto& [edge, balance] : walked) open += balance != 0;
    return open;
}

void expectNormalsAgreeWithFaces(const MeshDraft& mesh) {
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const auto& a = mesh.vertices[mesh.indices[i]];
        const auto& b = mesh.vertices[mesh.indices[i + 1]];
        const auto& c = mesh.vertices[mesh.indices[i + 2]];
        const glm::vec3 face = glm::cross(b.position - a.position, c.position - a.position);
        EXPECT_GT(glm::dot(face, a.normal + b.normal + c.normal), 0.0f);
    }
}

TEST(Shapes, ABoxEnclosesItsVolume) {
    MeshDraft mesh = shapes::draft("box", 0);
    shapes::addBox(mesh, {-1, -2, -3}, {1, 2, 3});
    EXPECT_NEAR(volume(mesh), 48.0, 1e-4);
    EXPECT_EQ(openEdges(mesh), 0);
    expectNormalsAgreeWithFaces(mesh);
}

TEST(Shapes, ASphereEnclosesItsVolume) {
    MeshDraft mesh = shapes::draft("sphere", 0);
    shapes::addSphere(mesh, {1, 2, 3}, 2.0f, 96);
    EXPECT_NEAR(volume(mesh), 4.0 / 3.0 * glm::pi<double>() * 8.0, 0.1);
    EXPECT_EQ(openEdges(mesh), 0);
    expectNormalsAgreeWithFaces(mesh);
    for (const Vertex& v : mesh.vertices)
        EXPECT_NEAR(glm::distance(v.position, glm::vec3(1, 2, 3)), 2.0f, 1e-5f);
}

TEST(Shapes, RotatedProfilesFaceOutwards) {
    MeshDraft mesh = shapes::draft("vase", 0);
    const std::vector<glm::vec2> profile = {{0, 0}, {1, 0}, {0.5f, 1}, {0.8f, 2}, {0, 2}};
    shapes::addLathe(mesh, {}, profile, 48);
    EXPECT_GT(volume(mesh), 0.0);
    EXPECT_EQ(openEdges(mesh), 0);
    expectNormalsAgreeWithFaces(mesh);
}

TEST(Shapes, TubesFaceOutwardsOpenAndClosed) {
    MeshDraft rod = shapes::draft("rod", 0);
    const std::vector<glm::vec3> line = {{0, 0, 0}, {0, 0.5f, 0}, {0, 1, 0}};
    shapes::addTube(
        rod, line, [](float) { return 0.1f; }, 64);
    EXPECT_NEAR(volume(rod), glm::pi<double>() * 0.01, 1e-4);
    EXPECT_EQ(openEdges(rod), 0);

    MeshDraft ring = shapes::draft("ring", 0);
    std::vector<glm::vec3> circle;
    for (int i = 0; i < 64; ++i) {
        const float a = glm::two_pi<float>() * static_cast<float>(i) / 64.0f;
        circle.emplace_back(std::cos(a), 0.0f, std::sin(a));
    }
    shapes::addTube(
        ring, circle, [](float) { return 0.1f; }, 32, true);
    EXPECT_NEAR(volume(ring), 2.0 * glm::pi<double>() * glm::pi<double>() * 0.01, 0.003);
    expectNormalsAgreeWithFaces(ring);
}

class BuiltinScenes : public testing::TestWithParam<std::string> {};

TEST_P(BuiltinScenes, IsValidAndReproducible) {
    const std::optional<Scene> scene = makeBuiltinScene(GetParam()),
                               again = makeBuiltinScene(GetParam());
    ASSERT_TRUE(scene && again);
    EXPECT_THAT(sceneProblems(*scene), testing::IsEmpty());
    EXPECT_THAT(scene->warnings, testing::IsEmpty()) << scene->warnings.front().message;
    EXPECT_EQ(scene->contentHash, again->contentHash);
    EXPECT_TRUE(scene->defaultView);
    EXPECT_FALSE(scene->title.empty());
}

INSTANTIATE_TEST_SUITE_P(All, BuiltinScenes,
                         testing::Values("chapel", "six-walls", "orbiting-cubes", "teapots",
                                         "meadow"),
                         [](const auto& row) {
                             std::string name = row.param;
                             std::replace(name.begin(), name.end(), '-', '_');
                             return name;
                         });

TEST(BuiltinScenes, OtherNamesAreUnknown) {
    EXPECT_FALSE(makeBuiltinScene("../chapel"));
}

TEST(Chapel, ContainsAllFourEffects) {
    const Scene scene = *makeBuiltinScene("chapel");
    const std::uint64_t triangles = triangleCount(scene);
    EXPECT_GE(triangles, 60'000u);
    EXPECT_LE(triangles, 150'000u);
    const auto material = [&](const std::string& name) {
        for (const Material& m : scene.materials) {
            if (m.name == name) return m;
        }
        ADD_FAILURE() << "no material " << name;
        return Material{};
    };
    EXPECT_GT(emittedRadiance(material("ember")).x, 1.0f);
    EXPECT_GT(material("glassBlue").transmission, 0.0f);
    EXPECT_LE(material("floor").roughness, 0.15f);
    EXPECT_EQ(material("brass").metallic, 1.0f);
    for (const Mesh& mesh : scene.meshes) {
        if (mesh.name == "floor") {
            EXPECT_EQ(mesh.bounds.min.y, mesh.bounds.max.y) << "the floor can be one mirror";
        }
    }
}

TEST(SixWalls, EveryWallEmitsItsColorInwards) {
    const Scene scene = sixWalls();
    for (std::size_t i = 0; i < 6; ++i) {
        const Mesh& mesh = scene.meshes[i];
        EXPECT_EQ(emittedRadiance(scene.materials[mesh.material]), kSixWallsRadiance[i]);
        const Vertex& v =
            scene.vertices[scene.indices[scene.clusters[mesh.firstCluster].firstIndex]];
        EXPECT_LT(glm::dot(v.normal, v.position), 0.0f) << mesh.name << " looks inwards";
    }
}

}  // namespace
}  // namespace clerestory::test
