// Animated files compared with a second reader (gltf_truth.h), and malformed ones.
#include "corners.h"
#include "gltf_truth.h"
#include "import_support.h"
#include "scene/import/cache/blob.h"

#include <gmock/gmock.h>

#include <cmath>

namespace clerestory {
namespace {

using test::forEachTriangle;
using test::GltfTruth;
using test::TruthTriangle;

// Area-weighted sums over all triangles, independent of their order.
struct AreaMoments {
    double area = 0.0;
    glm::dvec3 middle{0.0};  // area * centroid
    glm::dmat3 spread{0.0};  // area * centroid * centroid
    glm::dvec3 across{0.0};  // area * normal
    glm::dvec3 low{1e300}, high{-1e300};

    void add(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
        const glm::dvec3 n = 0.5 * glm::cross(b - a, c - a);
        const double size = glm::length(n);
        const glm::dvec3 at = (a + b + c) / 3.0;
        area += size;
        middle += size * at;
        spread += size * glm::outerProduct(at, at);
        across += n;
        for (const glm::dvec3& p : {a, b, c}) {
            low = glm::min(low, p);
            high = glm::max(high, p);
        }
    }
};

AreaMoments momentsOf(const Scene& scene, const Pose& pose) {
    AreaMoments moments;
    forEachTriangle(scene, pose,
                    [&](glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) { moments.add(a, b, c); });
    return moments;
}

AreaMoments momentsOf(const std::vector<TruthTriangle>& triangles) {
    AreaMoments moments;
    for (const TruthTriangle& t : triangles) {
        const auto point = [&](std::size_t i) { return glm::dvec3(t[i][0], t[i][1], t[i][2]); };
        moments.add(point(0), point(1), point(2));
    }
    return moments;
}

// Shares of the true pose's own size; vertices are floats, and matrices too in some files.
constexpr double kFloats = 2e-5;

void expectSame(const AreaMoments& ours, const AreaMoments& truth, const std::string& where) {
    const double size =
        glm::length(truth.high - truth.low) + glm::length(truth.middle) / truth.area;
    EXPECT_NEAR(ours.area, truth.area, 4 * kFloats * truth.area) << where;
    EXPECT_LT(glm::length(ours.low - truth.low), kFloats * size) << where;
    EXPECT_LT(glm::length(ours.high - truth.high), kFloats * size) << where;
    EXPECT_LT(glm::length(ours.middle - truth.middle), kFloats * size * truth.area) << where;
    EXPECT_LT(glm::length(ours.across - truth.across), 4 * kFloats * truth.area) << where;
    for (int i = 0; i < 3; ++i) {
        EXPECT_LT(glm::length(ours.spread[i] - truth.spread[i]),
                  4 * kFloats * size * size * truth.area)
            << where;
    }
}

// Normals of what is smooth may lean away from its triangles, but not to their backs.
double leastMeanFacing(const Scene& scene, const Pose& pose) {
    double least = 1.0;
    for (const Mesh& mesh : scene.meshes) {
        if (mesh.deformation == kNone) continue;
        const MeshVertices vertices = verticesOf(scene, pose, mesh);
        double sum = 0.0, area = 0.0;
        for (std::uint32_t c = 0; c < mesh.clusterCount; ++c) {
            const Cluster& cluster = scene.clusters[mesh.firstCluster + c];
            for (std::uint32_t i = 0; i < cluster.indexCount; i += 3) {
                const auto v = [&](std::uint32_t k) -> const Vertex& {
                    return vertices[scene.indices[cluster.firstIndex + i + k]];
                };
                const glm::dvec3 n = glm::cross(glm::dvec3(v(1).position - v(0).position),
                                                glm::dvec3(v(2).position - v(0).position));
                sum += glm::dot(n, glm::dvec3(v(0).normal + v(1).normal + v(2).normal) / 3.0);
                area += glm::length(n);
            }
        }
        least = std::min(least, sum / area);
    }
    return least;
}

struct File {
    const char* name;
    std::size_t clips;
    double facing;  // least mean of normals along triangles' normals
};
std::ostream& operator<<(std::ostream& out, const File& file) {
    return out << file.name;
}

class Animated : public testing::TestWithParam<File> {};

TEST_P(Animated, MatchesTheFile) {
    const auto file = sharedScene(GetParam().name);
    CLERESTORY_NEEDS(file);
    const Scene scene = importScene(file);
    GltfTruth truth(file);
    ASSERT_EQ(scene.clips.size(), GetParam().clips);
    ASSERT_EQ(truth.clipCount(), GetParam().clips);
    double moved = 0.0;
    for (Index clip = 0; clip < scene.clips.size(); ++clip) {
        if (!truth.clipName(clip).empty()) {
            EXPECT_EQ(scene.clips[clip].name, truth.clipName(clip));
        }
        EXPECT_NEAR(scene.clips[clip].duration, truth.duration(clip), 1e-6);
        // Between keys, at keys, before the first and at the end; many clips, fewer moments.
        std::vector<double> shares{0.0, 0.37, 1.0};
        if (scene.clips.size() < 4) shares.insert(shares.end(), {0.1, 0.5, 0.73, 0.999});
        AreaMoments first;
        for (const double share : shares) {
            const double time = share * truth.duration(clip);
            const std::string where = scene.clips[clip].name + " at " + std::to_string(time);
            truth.pose(clip, time);
            const Pose pose = poseAt(scene, std::span(&clip, 1), time);
            for (std::size_t i = 0; i < truth.order().size(); ++i) {
                const auto& m = truth.world(truth.order()[i]);
                double size = 0.0, worst = 0.0;
                for (int row = 0; row < 3; ++row) {
                    for (int column = 0; column < 4; ++column) {
                        const double value = m[row][column];
                        size = std::max(size, std::abs(value));
                        worst =
                            std::max(worst, std::abs(pose.worldFromNode[i][column][row] - value));
                    }
                }
                // A scale of 0 is a millionth with us.
                EXPECT_LT(worst, 3e-6 * size + 2e-6) << where << " node " << scene.nodes[i].name;
            }
            const AreaMoments ours = momentsOf(scene, pose);
            expectSame(ours, momentsOf(truth.triangles()), where);
            EXPECT_GT(leastMeanFacing(scene, pose), GetParam().facing) << where;
            if (share == 0.0) first = ours;
            moved = std::max(moved, glm::length(ours.middle - first.middle) / first.area);
            // Drawn geometry is within the bounds that culling uses.
            const Bounds box = worldBounds(scene, pose);
            const double slack = 1e-5 * box.diagonal();
            EXPECT_TRUE(glm::all(glm::lessThanEqual(glm::dvec3(box.min) - slack, ours.low)) &&
                        glm::all(glm::greaterThanEqual(glm::dvec3(box.max) + slack, ours.high)))
                << where;
        }
    }
    EXPECT_GT(moved, 0.0) << "the file moves something";
}

INSTANTIATE_TEST_SUITE_P(
    Files, Animated,
    testing::Values(File{"RobotExpressive/RobotExpressive.glb", 14, 0.5},
                    File{"Fox/Fox.gltf", 3, 0.999}, File{"CesiumMan/CesiumMan.glb", 1, 0.7},
                    File{"BoxAnimated/BoxAnimated.glb", 1, 0.9},
                    File{"InterpolationTest/InterpolationTest.glb", 9, 0.9},
                    File{"AnimatedMorphCube/AnimatedMorphCube.glb", 1, 0.5},
                    File{"SimpleSkin/SimpleSkin.gltf", 1, 0.999},
                    File{"SimpleMorph/SimpleMorph.gltf", 1, 0.999},
                    File{"RecursiveSkeletons/RecursiveSkeletons.glb", 1, 0.999}),
    [](const auto& file) {
        const std::string path = file.param.name;
        return path.substr(0, path.find('/'));
    });

TEST(AnimatedFiles, ABlobPreservesAnimations) {
    const auto file = sharedScene("RobotExpressive/RobotExpressive.glb");
    CLERESTORY_NEEDS(file);
    const Scene scene = importSceneInProcess(file);
    std::vector<std::byte> blob;
    writeScene(scene, [&](const void* bytes, std::size_t count) {
        const auto* from = static_cast<const std::byte*>(bytes);
        blob.insert(blob.end(), from, from + count);
    });
    Scene read = readScene(blob);
    EXPECT_EQ(read.contentHash, scene.contentHash);
    updateContentHash(read);
    EXPECT_EQ(read.contentHash, scene.contentHash);
    EXPECT_EQ(sceneProblems(read), std::vector<std::string>{});
    const Pose a = poseAt(scene, 0.4), b = poseAt(read, 0.4);
    ASSERT_EQ(a.deformed.size(), b.deformed.size());
    for (std::size_t i = 0; i < a.deformed.size(); ++i) {
        EXPECT_EQ(a.deformed[i]->hash, b.deformed[i]->hash);
    }
    // It has both morph targets and bones.
    EXPECT_FALSE(scene.morphWeights.empty());
    EXPECT_FALSE(scene.skins.empty());
}

TEST(AnimatedFiles, IndependentClipsPlayWithTheFirst) {
    const auto mobile = sharedScene("InterpolationTest/InterpolationTest.glb");
    CLERESTORY_NEEDS(mobile);
    EXPECT_EQ(defaultClips(importScene(mobile)).size(), 9u) << "nine cubes, nine clips";
    EXPECT_EQ(defaultClips(importScene(sharedScene("Fox/Fox.gltf"))).size(), 1u)
        << "three ways to walk";
}

TEST(AnimatedFiles, StaticFilesHaveNoAnimations) {
    const auto file = sharedScene("Box/Box.glb");
    CLERESTORY_NEEDS(file);
    const Scene scene = importScene(file);
    EXPECT_TRUE(scene.clips.empty() && scene.deformations.empty() && scene.movingNodes.empty());
    EXPECT_TRUE(poseAt(scene, 3.0).deformed.empty());
    EXPECT_TRUE(scene.reach.empty());
}

// World positions of the first instance's vertices.
std::vector<glm::dvec3> worldVertices(const Scene& scene, double time) {
    const Pose pose = poseAt(scene, time);
    const Instance& instance = scene.instances.at(0);
    const Mesh& mesh = scene.meshes[instance.mesh];
    const MeshVertices vertices = verticesOf(scene, pose, mesh);
    const Cluster& cluster = scene.clusters[mesh.firstCluster];
    std::vector<glm::dvec3> world;
    for (std::uint32_t i = 0; i < cluster.indexCount; ++i) {
        const glm::dvec3 place(vertices[scene.indices[cluster.firstIndex + i]].position);
        world.emplace_back(pose.worldFromNode[instance.node] * glm::dvec4(place, 1.0));
    }
    return world;
}

// ---- hostile files -------------------------------------------------------------------------

using Json = nlohmann::json;

std::string base64(const std::vector<float>& numbers) {
    const char* alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const auto* bytes = reinterpret_cast<const unsigned char*>(numbers.data());
    std::string out;
    for (std::size_t i = 0; i < 4 * numbers.size(); i += 3) {
        const auto byte = [&](std::size_t k) {
            return i + k < 4 * numbers.size() ? unsigned{bytes[i + k]} : 0u;
        };
        const unsigned bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for (int shift = 18; shift >= 0; shift -= 6) out += alphabet[bits >> shift & 63];
    }
    return out;
}

// A triangle at node 0 and a joint at node 1; accessors: 0 positions, 1 times, 2 translations,
// 3 rotations, 4 weights of the skin, 5 joints of it (zeros).
Json moving(std::vector<float> times = {0, 1}, std::vector<float> translations = {0, 0, 0, 5, 0, 0},
            std::vector<float> rotations = {0, 0, 0, 1, 0, 0, 1, 0}) {
    Json json = Json::parse(R"({"asset": {"version": "2.0"}, "scene": 0,
        "scenes": [{"nodes": [0, 1]}], "nodes": [{"mesh": 0}, {"name": "joint"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "animations": [{"name": "go", "samplers": [{"input": 1, "output": 2},
                                                   {"input": 1, "output": 3}],
            "channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}},
                         {"sampler": 1, "target": {"node": 1, "path": "rotation"}}]}]})");
    const auto add = [&](const std::vector<float>& numbers, const char* type, std::size_t width) {
        json["buffers"].push_back(
            {{"byteLength", 4 * numbers.size()},
             {"uri", "data:application/octet-stream;base64," + base64(numbers)}});
        json["bufferViews"].push_back(
            {{"buffer", json["buffers"].size() - 1}, {"byteLength", 4 * numbers.size()}});
        json["accessors"].push_back({{"bufferView", json["bufferViews"].size() - 1},
                                     {"componentType", 5126},
                                     {"count", numbers.size() / width},
                                     {"type", type}});
    };
    add({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3", 3);
    add(times, "SCALAR", 1);
    add(translations, "VEC3", 3);
    add(rotations, "VEC4", 4);
    add({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4", 4);
    json["accessors"].push_back({{"componentType", 5121}, {"count", 3}, {"type", "VEC4"}});
    return json;
}

Json skinned(Json json = moving()) {
    json["nodes"][0]["skin"] = 0;
    json["skins"] = Json::parse(R"([{"joints": [1]}])");
    json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = 5;
    json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = 4;
    return json;
}

Scene imported(const Json& json) {
    const TemporaryFolder folder;
    return importScene(folder.write("scene.gltf", json.dump()));
}

TEST(AnimatedFiles, BonesFarFromTheOriginMoveSmoothly) {
    const glm::dvec3 far(1e6 + 0.3, -250.0, -3e6);
    for (const bool moves : {true, false}) {
        Json near = skinned();
        if (!moves) near.erase("animations");
        near["scenes"][0]["nodes"] = {0, 2};
        near["nodes"].push_back({{"children", {1}}});
        Json away = near;
        away["nodes"][2]["translation"] = {far.x, far.y, far.z};
        const Scene here = imported(near), there = imported(away);
        EXPECT_EQ(here.deformations.size(), moves ? 1u : 0u);
        for (const double time : {0.0, 0.123, 0.777}) {
            const auto expected = worldVertices(here, time), found = worldVertices(there, time);
            ASSERT_EQ(found.size(), expected.size());
            // A float counts in quarters of a metre there.
            for (std::size_t i = 0; i < found.size(); ++i) {
                EXPECT_LT(glm::distance(found[i], expected[i] + far), 1e-4) << "at " << time;
            }
        }
    }
}

TEST(MalformedAnimations, TheValidAnimationPlays) {
    const Scene scene = imported(skinned());
    ASSERT_EQ(scene.clips.size(), 1u);
    EXPECT_EQ(scene.clips[0].tracks.size(), 2u);
    EXPECT_EQ(scene.deformations.size(), 1u);
    const Bounds box = worldBounds(scene, poseAt(scene, 1.0));
    EXPECT_NEAR(box.min.x, 4.0f, 1e-6) << "5 along x, and half a turn about z";
    EXPECT_NEAR(box.min.y, -1.0f, 1e-6);
}

TEST(MalformedAnimations, InvalidKeysAreIgnored) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float inf = std::numeric_limits<float>::infinity();
    const auto tracksLeft = [](const Json& json) {
        const Scene scene = imported(json);
        EXPECT_TRUE(warning(scene, "badAnimation"));
        return scene.clips.empty() ? 0u : unsigned(scene.clips[0].tracks.size());
    };
    EXPECT_EQ(tracksLeft(skinned(moving({1, 0}))), 0u) << "backwards";
    EXPECT_EQ(tracksLeft(skinned(moving({0, nan}))), 0u);
    EXPECT_EQ(tracksLeft(skinned(moving({-1, 1}))), 0u);
    EXPECT_EQ(tracksLeft(skinned(moving({0, 1}, {0, 0, 0, inf, 0, 0}))), 1u);
    EXPECT_EQ(tracksLeft(skinned(moving({0, 1}, {0, 0, 0, nan, 0, 0}))), 1u);
    EXPECT_EQ(tracksLeft(skinned(moving({0, 1, 2}))), 0u) << "more times than values";
    const auto changed = [](const char* pointer, const Json& value) {
        Json json = skinned();
        json[Json::json_pointer(pointer)] = value;
        return json;
    };
    EXPECT_EQ(tracksLeft(changed("/animations/0/channels/0/target/node", 7)), 1u);
    EXPECT_EQ(tracksLeft(changed("/animations/0/channels/0/target/path", "color")), 1u);
    EXPECT_EQ(tracksLeft(changed("/animations/0/channels/0/target/path", "rotation")), 1u);
    EXPECT_EQ(tracksLeft(changed("/animations/0/channels/0/target/path", "weights")), 1u)
        << "the node has no morph targets";
    EXPECT_EQ(tracksLeft(changed("/animations/0/channels/0/sampler", 5)), 1u);
    EXPECT_EQ(tracksLeft(changed("/animations/0/samplers/0/input", 99)), 1u);
    EXPECT_EQ(tracksLeft(changed("/animations/0/samplers/0/output", -3)), 1u);
    EXPECT_EQ(tracksLeft(changed("/animations/0/channels/1/target/path", "translation")), 1u);
    EXPECT_EQ(tracksLeft(changed("/animations/0/samplers", "none")), 0u);
}

TEST(MalformedAnimations, InvalidSkinsAreIgnored) {
    const auto changed = [](const char* pointer, const Json& value) {
        Json json = skinned();
        json[Json::json_pointer(pointer)] = value;
        return json;
    };
    // Each stands somewhere, with finite vertices: importScene() has checked it.
    imported(changed("/skins/0/joints", {1, 57}));
    imported(changed("/skins/0/joints", {1, 1, 1, 0}));
    imported(changed("/skins/0/inverseBindMatrices", 3));
    imported(changed("/meshes/0/primitives/0/attributes/WEIGHTS_0", 0));
    imported(changed("/meshes/0/primitives/0/attributes/JOINTS_0", 0));
    imported(changed("/nodes/1/scale", {0, 0, 0}));
    const TemporaryFolder folder;
    const auto reason = [&](const Json& json) {
        return refusal(folder.write("s.gltf", json.dump())).reason();
    };
    EXPECT_EQ(reason(changed("/skins/0/joints", Json::array())), ImportError::Reason::malformed);
    EXPECT_EQ(reason(changed("/nodes/0/skin", 4)), ImportError::Reason::malformed);
    EXPECT_EQ(reason(changed("/nodes/1/children", {1})), ImportError::Reason::malformed)
        << "a skeleton that is its own child";
}

TEST(MalformedAnimations, ZeroScaleRecovers) {
    Json json = moving({0, 1}, {0, 0, 0, 1, 1, 1});
    json["nodes"][0]["scale"] = {0, 0, 0};
    json["animations"][0]["channels"] =
        Json::parse(R"([{"sampler": 0, "target": {"node": 0, "path": "scale"}}])");
    const Scene scene = imported(json);
    ASSERT_EQ(scene.instances.size(), 1u);
    EXPECT_LT(worldBounds(scene, restPose(scene)).diagonal(), 1e-5f);
    EXPECT_NEAR(worldBounds(scene, poseAt(scene, 1.0)).max.x, 1.0f, 1e-6);
}

}  // namespace
}  // namespace clerestory
