// Lines and points of every format: their number, bounds, colours and normals, and files that are
// wrong.
#include "import_support.h"
#include "tests/support/glb_builder.h"
#include "tests/support/scene_files.h"

#include "scene/bvh.h"
#include "scene/default_view.h"
#include "scene/fit.h"
#include "scene/import/cache/blob.h"
#include "scene/mesh_builder.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <limits>
#include <set>

namespace clerestory::test {
namespace {

using testing::HasSubstr;
using testing::Not;

const std::vector<glm::vec3> kFive{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 2}};

// A mesh of these vertices in a mode of glTF.
GlbBuilder modeGlb(int mode, const std::vector<glm::vec3>& positions = kFive) {
    GlbBuilder builder;
    builder.primitive()["mode"] = mode;
    builder.primitive()["attributes"]["POSITION"] =
        builder.accessor(builder.view(bytesOf(positions)), kGltfFloat, positions.size(), "VEC3");
    return builder;
}

Scene imported(const GlbBuilder& builder) {
    const TemporaryFolder folder;
    return importSceneInProcess(folder.write("marks.glb", builder.glb()));
}

ImportError refused(const GlbBuilder& builder, const ImportOptions& options = {}) {
    const TemporaryFolder folder;
    return refusal(folder.write("marks.glb", builder.glb()), options);
}

using Ends = std::vector<std::pair<glm::vec3, glm::vec3>>;
Ends linesOf(const Scene& scene) {
    Ends lines;
    for (const Cluster& cluster : scene.clusters) {
        for (std::uint32_t i = 0; i < cluster.indexCount; i += 2) {
            lines.emplace_back(scene.vertices[scene.indices[cluster.firstIndex + i]].position,
                               scene.vertices[scene.indices[cluster.firstIndex + i + 1]].position);
        }
    }
    return lines;
}

TEST(LinesAndPoints, ModesOfGltf) {
    const Scene points = imported(modeGlb(0));
    EXPECT_EQ(primitiveCount(points, Primitive::points), 5u);
    EXPECT_EQ(primitiveCount(points, Primitive::lines), 0u);
    EXPECT_EQ(triangleCount(points), 0u);
    EXPECT_FALSE(points.meshes[0].lit);
    EXPECT_EQ(points.meshes[0].bounds.max, glm::vec3(1, 1, 2));
    const std::vector<glm::vec3>& p = kFive;
    EXPECT_EQ(linesOf(imported(modeGlb(1))), (Ends{{p[0], p[1]}, {p[2], p[3]}})) << "the fifth";
    const Ends strip{{p[0], p[1]}, {p[1], p[2]}, {p[2], p[3]}, {p[3], p[4]}};
    EXPECT_EQ(linesOf(imported(modeGlb(3))), strip);
    Ends loop = strip;
    loop.emplace_back(p[4], p[0]);
    EXPECT_EQ(linesOf(imported(modeGlb(2))), loop);
}

TEST(LinesAndPoints, IndicesNormalsAndColours) {
    GlbBuilder builder = modeGlb(0);
    const std::vector<glm::vec3> up(5, {0, 2, 0}), colors(5, {0.5f, 0.25f, 0.0f});
    auto& attributes = builder.primitive()["attributes"];
    attributes["NORMAL"] = builder.accessor(builder.view(bytesOf(up)), kGltfFloat, 5, "VEC3");
    attributes["COLOR_0"] = builder.accessor(builder.view(bytesOf(colors)), kGltfFloat, 5, "VEC3");
    builder.primitive()["indices"] =
        builder.accessor(builder.view(bytesOfIndices({4, 2, 9}, kGltfUnsignedShort)),
                         kGltfUnsignedShort, 3, "SCALAR");
    const Scene scene = imported(builder);
    EXPECT_EQ(primitiveCount(scene, Primitive::points), 2u);
    EXPECT_TRUE(warning(scene, "indexOutOfRange"));
    ASSERT_EQ(scene.vertices.size(), 2u);
    EXPECT_TRUE(scene.meshes[0].lit);
    EXPECT_TRUE(scene.meshes[0].hasColors);
    EXPECT_EQ(scene.vertices[0].normal, glm::vec3(0, 1, 0));
    EXPECT_EQ(scene.vertices[0].color, glm::vec4(0.5f, 0.25f, 0.0f, 1.0f));
    EXPECT_EQ(scene.indices.size(), 3u) << "filled up";
}

TEST(LinesAndPoints, WrongFilesOfGltf) {
    EXPECT_THAT(refused(modeGlb(7)).what(), HasSubstr("no primitive mode 7"));
    EXPECT_EQ(refused(modeGlb(7)).reason(), ImportError::Reason::malformed);
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    const Scene scene = imported(modeGlb(0, {{0, 0, 0}, {kNan, 0, 0}, {1, 1, 1}}));
    EXPECT_EQ(primitiveCount(scene, Primitive::points), 2u);
    EXPECT_TRUE(warning(scene, "nonFiniteVertices"));
    const Scene lines = imported(modeGlb(3, {{0, 0, 0}, {0, 0, 0}, {1, 1, 1}}));
    EXPECT_EQ(primitiveCount(lines, Primitive::lines), 1u);
    EXPECT_TRUE(warning(lines, "degenerateLines"));
    EXPECT_THAT(refused(modeGlb(1, {{0, 0, 0}})).what(),
                HasSubstr("no triangles, lines or points"));
    EXPECT_THAT(refused(modeGlb(3, {{1, 1, 1}, {1, 1, 1}})).what(),
                HasSubstr("no triangles, lines or points"));
    ImportOptions options;
    options.limits.maxTriangles = 4;
    const ImportError many = refused(modeGlb(0), options);
    EXPECT_EQ(many.reason(), ImportError::Reason::limit);
    EXPECT_THAT(many.what(), HasSubstr("more than 4 triangles, lines and points"));
}

TEST(LinesAndPoints, ElementsOfObj) {
    const TemporaryFolder folder;
    const Scene scene = importSceneInProcess(
        folder.write("wire.obj",
                     "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 0.5\nvn 0 0 1\n"
                     "l 1 2 3 4 1\np 5\np 1\nf 1//1 2//1 3//1\n"));
    EXPECT_EQ(primitiveCount(scene, Primitive::lines), 4u);
    EXPECT_EQ(primitiveCount(scene, Primitive::points), 2u);
    EXPECT_EQ(triangleCount(scene), 1u);
    for (const Mesh& mesh : scene.meshes) {
        EXPECT_EQ(mesh.lit, mesh.primitive == Primitive::triangles);
        if (mesh.primitive == Primitive::triangles) {
            EXPECT_EQ(scene.clusters[mesh.firstCluster].firstIndex % 3, 0u);
        }
    }
    EXPECT_EQ(sceneProblems(scene), std::vector<std::string>{});
    // Rays meet the triangle and nothing else.
    EXPECT_EQ(stillTriangles(scene, restPose(scene), {}).triangles.size(), 1u);
}

TEST(LinesAndPoints, PointCloudsOfPly) {
    const TemporaryFolder folder;
    const std::string header =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\n";
    const std::string colors = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    const Scene cloud = importSceneInProcess(folder.write(
        "cloud.ply",
        header + colors + "end_header\n0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 255\n"));
    EXPECT_EQ(primitiveCount(cloud, Primitive::points), 3u);
    EXPECT_FALSE(cloud.meshes[0].lit);
    ASSERT_EQ(cloud.vertices.size(), 3u);
    EXPECT_EQ(cloud.vertices[1].color, glm::vec4(0, 1, 0, 1));
    const Scene lit = importSceneInProcess(
        folder.write("lit.ply", header + "property float nx\nproperty float ny\nproperty float nz\n"
                                         "end_header\n0 0 0 0 1 0\n1 0 0 0 1 0\n0 1 0 0 1 0\n"));
    EXPECT_TRUE(lit.meshes[0].lit);
    EXPECT_EQ(lit.vertices[2].normal, glm::vec3(0, 1, 0));
    const Scene mesh = importSceneInProcess(
        folder.write("mesh.ply", header + "element face 1\nproperty list uchar int vertex_indices\n"
                                          "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"));
    EXPECT_EQ(triangleCount(mesh), 1u);
    EXPECT_EQ(primitiveCount(mesh, Primitive::points), 0u);
    const std::string nothing = "ply\nformat ascii 1.0\nend_header\n";
    EXPECT_EQ(refusal(folder.write("wrong.ply", nothing)).reason(), ImportError::Reason::malformed);
    const std::string nan = header + "end_header\nnan nan nan\nnan nan nan\nnan nan nan\n";
    EXPECT_THAT(refusal(folder.write("wrong.ply", nan)).what(),
                HasSubstr("no triangles, lines or points"));
}

// Vertices without elements are points, with colours, and with normals if each has one; and point
// elements alone.
TEST(LinesAndPoints, PointCloudsOfObj) {
    const TemporaryFolder folder;
    const auto cloudOf = [&](const std::string& text) {
        const Scene scene = importSceneInProcess(folder.write("cloud.obj", text));
        EXPECT_EQ(triangleCount(scene), 0u);
        EXPECT_EQ(sceneProblems(scene), std::vector<std::string>{});
        return scene;
    };
    const auto placesOf = [](const Scene& scene) {
        std::vector<std::array<float, 3>> places;
        for (const Cluster& cluster : scene.clusters) {
            for (std::uint32_t i = 0; i < cluster.indexCount; ++i) {
                const glm::vec3 p = scene.vertices[scene.indices[cluster.firstIndex + i]].position;
                places.push_back({p.x, p.y, p.z});
            }
        }
        std::sort(places.begin(), places.end());
        return places;
    };
    using Places = std::vector<std::array<float, 3>>;
    const Scene plain = cloudOf("# three\nv 0 0 0\n  v 1 0 2\nv 0 1 0");
    EXPECT_EQ(placesOf(plain), (Places{{0, 0, 0}, {0, 1, 0}, {1, 0, 2}}));
    EXPECT_FALSE(plain.meshes[0].lit);
    const Scene lit = cloudOf("vn 0 0 1\nv 0 0 0\nvn 0 1 0\nv 1 0 2\n");
    ASSERT_EQ(lit.vertices.size(), 2u);
    EXPECT_TRUE(lit.meshes[0].lit);
    for (const Vertex& v : lit.vertices) {
        EXPECT_EQ(v.normal, v.position.x > 0.5f ? glm::vec3(0, 1, 0) : glm::vec3(0, 0, 1));
    }
    const Scene colored = cloudOf("v 0 0 0 1 0 0\nv 1 0 2 0 0 1\n");
    ASSERT_EQ(colored.vertices.size(), 2u);
    for (const Vertex& v : colored.vertices) {
        EXPECT_EQ(v.color, v.position.x > 0.5f ? glm::vec4(0, 0, 1, 1) : glm::vec4(1, 0, 0, 1));
    }
    EXPECT_EQ(placesOf(cloudOf("v 0 0 0\nv 1 0 2\nv 0 1 0\np 3 1\n")),
              (Places{{0, 0, 0}, {0, 1, 0}}));
    std::string many;
    for (int i = 0; i < 5000; ++i) many += "v " + std::to_string(i) + " 0.5 0.25\n";
    EXPECT_EQ(primitiveCount(cloudOf(many), Primitive::points), 5000u);
    EXPECT_THAT(refusal(folder.write("empty.obj", "# nothing\n")).what(), Not(HasSubstr("crash")));
    ImportOptions options;
    options.limits.maxTriangles = 4000;
    EXPECT_EQ(refusal(folder.write("many.obj", many), options).reason(),
              ImportError::Reason::limit);
    const auto file = sharedScene("FormatsOBJ/point_cloud.obj");
    CLERESTORY_NEEDS(file);
    EXPECT_EQ(primitiveCount(importSceneInProcess(file), Primitive::points), 3u);
}

// 10,000 points: clusters of at most kClusterPrimitives, each point once.
TEST(LinesAndPoints, AreCutIntoClusters) {
    Scene scene;
    scene.materials.emplace_back();
    MeshDraft draft{.name = "cloud", .primitive = Primitive::points};
    for (std::uint32_t i = 0; i < 10'000; ++i) {
        draft.vertices.push_back({.position = glm::vec3(i % 100, i / 100, 0)});
        draft.indices.push_back(i);
    }
    addInstance(scene, addNode(scene, "cloud"), addMesh(scene, draft));
    EXPECT_GE(scene.clusters.size(), 5u);
    EXPECT_EQ(sceneProblems(scene), std::vector<std::string>{});
    std::set<std::pair<float, float>> seen;
    for (const Cluster& cluster : scene.clusters) {
        EXPECT_LT(cluster.bounds.diagonal(), 90.0f) << "close together";
        for (std::uint32_t i = 0; i < cluster.indexCount; ++i) {
            const glm::vec3 p = scene.vertices[scene.indices[cluster.firstIndex + i]].position;
            seen.emplace(p.x, p.y);
        }
    }
    EXPECT_EQ(seen.size(), 10'000u);
    updateContentHash(scene);
    std::vector<std::byte> blob;
    writeScene(scene, [&](const void* bytes, std::size_t count) {
        const auto* from = static_cast<const std::byte*>(bytes);
        blob.insert(blob.end(), from, from + count);
    });
    const Scene back = readScene(blob);
    EXPECT_EQ(back.meshes[0].primitive, Primitive::points);
    EXPECT_EQ(back.meshes[0].primitives, 10'000u);
    EXPECT_FALSE(back.meshes[0].lit);
    Scene other = scene;
    other.meshes[0].primitive = Primitive::lines;
    EXPECT_NE(sceneProblems(other), std::vector<std::string>{});
    updateContentHash(other);
    EXPECT_NE(other.contentHash, scene.contentHash);
}

// The view of points is fitted as that of a surface with the same corners is.
TEST(LinesAndPoints, HaveAFittedView) {
    const Scene points = imported(modeGlb(0)), surface = imported(modeGlb(5));
    const DefaultView a = fittedView(points), b = fittedView(surface);
    EXPECT_NEAR(glm::distance(a.position, b.position), 0.0, 1e-6);
    EXPECT_NEAR(glm::distance(a.target, b.target), 0.0, 1e-6);
    EXPECT_EQ(lastingBounds(points, restPose(points)).max, glm::vec3(1, 1, 2));
    // A point has no extent: a metre away.
    const Scene one = imported(modeGlb(0, {{3, 2, 1}}));
    const DefaultView near = fittedView(one);
    EXPECT_NEAR(glm::distance(near.position, glm::dvec3(3, 2, 1)), 1.0, 1e-6);
    EXPECT_NEAR(glm::distance(near.target, glm::dvec3(3, 2, 1)), 0.0, 1e-6);
    // A line across the frame is something that a camera sees.
    const Scene line = imported(modeGlb(1, {{-1, 0, 0}, {1, 0, 0}}));
    const DefaultView ahead{.position = {0, 0, 2}, .target = {0, 0, 0}, .yfov = 0.9};
    EXPECT_GT(coveredShare(line, restPose(line), ahead), 0.004);
    const DefaultView away{.position = {0, 0, 2}, .target = {0, 0, 4}, .yfov = 0.9};
    EXPECT_EQ(coveredShare(line, restPose(line), away), 0.0);
}

// Points with a morph target that a clip plays: they move as vertices of surfaces do.
TEST(LinesAndPoints, Deform) {
    for (const int mode : {0, 3}) {
        GlbBuilder builder = modeGlb(mode);
        const std::vector<glm::vec3> offsets(5, {0, 4, 0});
        builder.primitive()["targets"] = {
            {{"POSITION",
              builder.accessor(builder.view(bytesOf(offsets)), kGltfFloat, 5, "VEC3")}}};
        const int times = builder.accessor(builder.view(bytesOf(std::vector<float>{0, 2})),
                                           kGltfFloat, 2, "SCALAR");
        const int weights = builder.accessor(builder.view(bytesOf(std::vector<float>{0, 1})),
                                             kGltfFloat, 2, "SCALAR");
        builder.json()["animations"] = {
            {{"samplers", {{{"input", times}, {"output", weights}}}},
             {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}}}};
        const Scene scene = imported(builder);
        ASSERT_EQ(scene.deformations.size(), 1u);
        EXPECT_EQ(sceneProblems(scene), std::vector<std::string>{});
        const Pose pose = poseAt(scene, 1.0);
        const MeshVertices vertices = verticesOf(scene, pose, scene.meshes[0]);
        for (const Cluster& cluster : scene.clusters) {
            for (std::uint32_t i = 0; i < cluster.indexCount; ++i) {
                const std::uint32_t index = scene.indices[cluster.firstIndex + i];
                EXPECT_EQ(vertices[index].position,
                          scene.vertices[index].position + glm::vec3(0, 2, 0));
            }
        }
        EXPECT_EQ(boundsOf(pose, scene.meshes[0]).max, glm::vec3(1, 3, 2));
        EXPECT_EQ(scene.meshes[0].area, 0.0);
    }
}

// Seven points; six lines, a loop of seven, a strip of six; a hexagon in each mode of triangles.
TEST(LinesAndPoints, EveryModeOfASharedFile) {
    const auto file = sharedScene("MeshPrimitiveModes/MeshPrimitiveModes.gltf");
    CLERESTORY_NEEDS(file);
    const Scene scene = importSceneInProcess(file);
    EXPECT_EQ(primitiveCount(scene, Primitive::points), 7u);
    EXPECT_EQ(primitiveCount(scene, Primitive::lines), 19u);
    EXPECT_EQ(triangleCount(scene), 16u);
    EXPECT_TRUE(scene.warnings.empty());
}

}  // namespace
}  // namespace clerestory::test
