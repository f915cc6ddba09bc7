// Clips of COLLADA and FBX compared with hand-computed poses.
#include "corners.h"
#include "import_support.h"

#include <gmock/gmock.h>
#include <regex>
#include <sstream>

#include <numbers>

namespace clerestory {
namespace {

// World positions of an instance's vertices, sorted.
std::vector<std::array<double, 3>> corners(const Scene& scene, const Pose& pose, Index instance) {
    const Instance& i = scene.instances.at(instance);
    const Mesh& mesh = scene.meshes[i.mesh];
    const MeshVertices vertices = verticesOf(scene, pose, mesh);
    std::vector<std::array<double, 3>> found;
    for (std::uint32_t c = 0; c < mesh.clusterCount; ++c) {
        const Cluster& cluster = scene.clusters[mesh.firstCluster + c];
        for (std::uint32_t k = 0; k < cluster.indexCount; ++k) {
            const Vertex& v = vertices[scene.indices[cluster.firstIndex + k]];
            const glm::dvec4 p = pose.worldFromNode[i.node] * glm::dvec4(v.position, 1.0);
            found.push_back({p.x, p.y, p.z});
        }
    }
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
}

double areaOf(const Scene& scene, const Pose& pose) {
    double area = 0.0;
    test::forEachTriangle(scene, pose, [&](glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
        area += 0.5 * glm::length(glm::cross(b - a, c - a));
    });
    return area;
}

void expectCorners(const Scene& scene, double time, Index instance,
                   std::vector<std::array<double, 3>> expected) {
    const auto found = corners(scene, poseAt(scene, time), instance);
    std::sort(expected.begin(), expected.end());
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            EXPECT_NEAR(found[i][k], expected[i][k], 1e-6) << "corner " << i << " at " << time;
        }
    }
}

TEST(AssimpMotion, NodesMatchTheFile) {
    const Scene scene = importScene(ownScene("moving.dae"));
    ASSERT_EQ(scene.clips.size(), 1u);
    EXPECT_NEAR(scene.clips[0].duration, 2.0, 1e-6);
    EXPECT_TRUE(scene.warnings.empty());
    // Half a metre each unit; half way a turn of 45 degrees.
    const double half = std::numbers::sqrt2 / 4.0;
    expectCorners(scene, 0.0, 0, {{0, 0, 0}, {0.5, 0, 0}, {0, 0.5, 0}});
    expectCorners(scene, 1.0, 0, {{1, 0, 0}, {1 + half, half, 0}, {1 - half, half, 0}});
    expectCorners(scene, 2.0 - 1e-9, 0, {{2, 0, 0}, {2, 0.5, 0}, {1.5, 0, 0}});
}

TEST(AssimpMotion, VerticesFollowTheirWeights) {
    const Scene scene = importScene(ownScene("moving.dae"));
    ASSERT_EQ(scene.deformations.size(), 1u);
    ASSERT_EQ(scene.instances.size(), 2u);
    expectCorners(scene, 0.0, 1, {{0, 0, 0}, {0, 0.5, 0}, {1, 0, 0}, {1, 0.5, 0}});
    // The corner that both joints weight is three quarters of the way from (2, 1) to (0, 1).
    for (const double time : {1.0, 1.5}) {
        expectCorners(scene, time, 1, {{0, 0, 0}, {0, 0.5, 0}, {0.5, 0.5, 0}, {0.25, 0.5, 0}});
    }
}

TEST(AssimpMotion, BonesFarFromTheOriginMoveSmoothly) {
    std::ifstream stream(ownScene("moving.dae"));
    std::string model{std::istreambuf_iterator<char>(stream), {}};
    const std::string stem = R"(type="JOINT">)";
    model.insert(model.find(stem) + stem.size(), "<translate>2000000 0 6000000</translate>");
    const TemporaryFolder folder;
    const Scene scene = importScene(folder.write("far.dae", model));
    expectCorners(scene, 1.0, 1,
                  {{1e6, 0, 3e6}, {1e6, 0.5, 3e6}, {1e6 + 0.5, 0.5, 3e6}, {1e6 + 0.25, 0.5, 3e6}});
}

TEST(AssimpMotion, OnlyMovingNodesHaveTracks) {
    const Scene scene = importScene(ownScene("moving.dae"));
    std::size_t translations = 0, rotations = 0;
    for (const Track& track : scene.clips.at(0).tracks) {
        translations += track.property == AnimatedProperty::translation ? 1 : 0;
        rotations += track.property == AnimatedProperty::rotation ? 1 : 0;
    }
    EXPECT_EQ(translations, 1u);
    EXPECT_EQ(rotations, 2u);
    EXPECT_EQ(scene.clips[0].tracks.size(), 3u) << "nothing changes its size";
    EXPECT_EQ(scene.movingNodes.size(), 2u);
    EXPECT_EQ(importScene(ownScene("materials.obj")).clips.size(), 0u);
}

TEST(AssimpMotion, FbxSkeletonsStayConnected) {
    const auto file = sharedScene("FormatsFBX/animation_with_skeleton.fbx");
    CLERESTORY_NEEDS(file);
    const Scene scene = importScene(file);
    ASSERT_FALSE(scene.clips.empty());
    ASSERT_FALSE(scene.deformations.empty());
    // Bones turn their flesh and hardly stretch it; a wrong bind pose tears it apart.
    const double atRest = areaOf(scene, restPose(scene));
    double furthest = 0.0;
    const Pose start = poseAt(scene, 0.0);
    for (const double share : {0.0, 0.2, 0.4, 0.6, 0.8}) {
        const Pose pose = poseAt(scene, share * scene.clips[0].duration);
        EXPECT_NEAR(areaOf(scene, pose) / atRest, 1.0, 0.1) << share;
        for (std::size_t i = 0; i < pose.deformed.size(); ++i) {
            const auto &now = pose.deformed[i]->vertices, &then = start.deformed[i]->vertices;
            for (std::size_t v = 0; v < now.size(); ++v) {
                furthest =
                    std::max(furthest, double{glm::distance(now[v].position, then[v].position)});
            }
        }
    }
    EXPECT_GT(furthest, 0.01 * worldBounds(scene, start).diagonal()) << "something moves";
}

// XML allows spaces before numbers, which some exporters write after every tag.
TEST(Collada, SpacesBeforeNumbersChangeNothing) {
    std::ifstream stream(ownScene("moving.dae"));
    std::stringstream text;
    text << stream.rdbuf();
    const std::string spaced =
        std::regex_replace(text.str(), std::regex(">(?=[-+.0-9])"), ">\n \t ");
    ASSERT_NE(spaced, text.str());
    const TemporaryFolder folder;
    const Scene plain = importScene(folder.write("a/scene.dae", text.str()));
    const Scene other = importScene(folder.write("b/scene.dae", spaced));
    EXPECT_EQ(other.contentHash, plain.contentHash);
}

}  // namespace
}  // namespace clerestory
