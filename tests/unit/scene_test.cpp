// Poses, bounds, identity, and the validation that finds every planted fault.
#include "plan_scenes.h"
#include "scene/default_view.h"

#include "scene/normal_maps.h"
#include "scene/texture_images.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <set>

namespace clerestory::test {
namespace {

// A wave along x: its slope is that of a sine.
TEST(TextureImages, SlopesOfNormalMapsAreRootMeanSquares) {
    TextureImage image{.width = 64, .height = 8, .colorSpace = ColorSpace::linear};
    for (int i = 0; i < 64 * 8; ++i) {
        const double slope = 0.4 * std::sin(2.0 * 3.14159265358979 * (i % 64) / 64.0);
        const glm::dvec3 n = glm::normalize(glm::dvec3(-slope, 0.0, 1.0));
        for (int k = 0; k < 3; ++k) {
            image.texels.push_back(static_cast<std::uint8_t>(std::lround(127.5 * (n[k] + 1.0))));
        }
        image.texels.push_back(255);
    }
    const auto slopeOf = [](TextureImage texels, bool isNormalMap) {
        Scene scene;
        buildLevels(texels);
        scene.images.push_back(std::move(texels));
        scene.textures.push_back({.image = 0});
        Material& m = scene.materials.emplace_back();
        (isNormalMap ? m.normalTexture : m.metallicRoughnessTexture).texture = 0;
        packNormals(scene);
        return scene.images[0].slope;
    };
    EXPECT_NEAR(slopeOf(image, true), 0.4 / std::sqrt(2.0), 3e-3);
    EXPECT_EQ(slopeOf(image, false), 0.0f) << "not a normal map";
    for (std::size_t i = 0; i < image.texels.size(); ++i) {
        image.texels[i] = i % 4 < 2 ? 128 : 255;  // as editors write an even surface
    }
    EXPECT_EQ(slopeOf(image, true), 0.0f);
}

TEST(Pose, ChildrenFollowTheirParents) {
    Scene scene;
    const Index parent = addNode(scene, "parent", glm::translate(glm::dmat4(1.0), {1, 2, 3}));
    addNode(scene, "child", glm::scale(glm::dmat4(1.0), glm::dvec3(2)), parent);
    const Pose pose = poseAt(scene, 0.0);
    EXPECT_EQ(pose.worldFromNode[1] * glm::dvec4(1, 0, 0, 1), glm::dvec4(3, 2, 3, 1));
}

// Found by fuzzing: what clips did to a tree could be more than a box holds.
TEST(Pose, NonFiniteTimesAreTheRestPose) {
    const auto grown = [](float scale, double time) {
        Scene scene = boxScene();
        scene.movingNodes.push_back({.node = 0});
        scene.clips.push_back({.name = "grow",
                               .duration = 1.0,
                               .tracks = {{.property = AnimatedProperty::scale,
                                           .target = 0,
                                           .times = {0.0f, 1.0f},
                                           .values = {1.0f, 1.0f, 1.0f, scale, 1.0f, 1.0f}}}});
        return worldBounds(scene, poseAt(scene, time)).max.x;
    };
    const float rest = grown(1.0f, 0.0);
    EXPECT_EQ(grown(3.0f, 0.999999), rest * static_cast<float>(1.0 + 2.0 * 0.999999));
    EXPECT_GT(grown(1e9f, 0.5), 1e8f * rest);
    Scene deep = boxScene();
    for (Index i = 0; i < 3; ++i) {
        const Index node = addNode(deep, "deeper", glm::dmat4(1.0), i);
        deep.movingNodes.push_back({.node = node});
    }
    addInstance(deep, 3, 0, 0);
    deep.clips.push_back({.name = "grow", .duration = 1.0});
    for (Index i = 0; i < 3; ++i) {
        deep.clips[0].tracks.push_back({.property = AnimatedProperty::scale,
                                        .target = i,
                                        .times = {0.0f, 1.0f},
                                        .values = {1.0f, 1.0f, 1.0f, 1e9f, 1.0f, 1.0f}});
    }
    const Bounds atRest = worldBounds(deep, restPose(deep));
    EXPECT_GT(worldBounds(deep, poseAt(deep, 1e-9)).max.x, atRest.max.x);
    EXPECT_EQ(worldBounds(deep, poseAt(deep, 0.999999)).max.x, atRest.max.x) << "not 1e27 metres";
}

TEST(Bounds, OfARotatedBoxEncloseItsCornersTightly) {
    Bounds unit;
    unit.add(glm::vec3(-1));
    unit.add(glm::vec3(1));
    const Bounds turned =
        transformed(unit, glm::rotate(glm::dmat4(1.0), glm::radians(45.0), {0, 0, 1}));
    EXPECT_NEAR(turned.max.x, std::sqrt(2.0f), 1e-6f);
    EXPECT_NEAR(turned.max.z, 1.0f, 1e-6f);
    EXPECT_TRUE(transformed(Bounds{}, glm::dmat4(1.0)).empty());
}

TEST(Scene, WorldBoundsCoverEveryInstance) {
    Scene scene = boxScene();
    place(scene, 0, {10, 0, 0}, 2.0);
    const Bounds bounds = worldBounds(scene, poseAt(scene, 0));
    EXPECT_EQ(bounds.min, glm::vec3(-1, -2, -2));
    EXPECT_EQ(bounds.max, glm::vec3(12, 2, 2));
    EXPECT_EQ(triangleCount(scene), 24u);
}

// Of the corners of all instances: the most that they are away from the middle of a frame of this
// aspect, in halves of its width and height.
glm::dvec2 extentIn(const Scene& scene, const DefaultView& view, double aspect) {
    const Pose pose = poseAt(scene, 0.0);
    const glm::dvec3 back = glm::normalize(view.position - view.target);
    const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), back));
    const glm::dvec3 up = glm::cross(back, right);
    const double tangent = std::tan(0.5 * fieldOfView(view, aspect));
    glm::dvec2 extent(0.0);
    for (const Instance& instance : scene.instances) {
        const Mesh& mesh = scene.meshes[instance.mesh];
        for (std::uint32_t k = 0; k < mesh.clusterCount; ++k) {
            const Cluster& cluster = scene.clusters[mesh.firstCluster + k];
            for (std::uint32_t i = 0; i < cluster.indexCount; ++i) {
                const Vertex& vertex = scene.vertices[scene.indices[cluster.firstIndex + i]];
                const glm::dvec3 p = glm::dvec3(pose.worldFromNode[instance.node] *
                                                glm::dvec4(vertex.position, 1.0)) -
                                     view.position;
                const double depth = -glm::dot(p, back);
                EXPECT_GT(depth, 0.0);
                extent = glm::max(
                    extent, glm::abs(glm::dvec2(glm::dot(p, right) / aspect, glm::dot(p, up)) /
                                     (depth * tangent)));
            }
        }
    }
    return extent;
}

// The narrower margin is a tenth of the frame on each side.
TEST(DefaultView, FillsTheSameShareOfFramesOfEveryShapeAtAnyScale) {
    for (const double size : {1e-4, 1.0, 1e6}) {
        for (const glm::dvec3& shape :
             {glm::dvec3(1, 1, 1), glm::dvec3(8, 1, 1), glm::dvec3(1, 9, 1), glm::dvec3(1, 1, 7)}) {
            Scene scene;
            place(scene, addBoxMesh(scene, "box", addMaterial(scene, {})), {3 * size, 0, 0}, size);
            scene.nodes.back().parentFromLocal =
                glm::scale(scene.nodes.back().parentFromLocal, shape);
            const DefaultView view = defaultView(scene);
            for (const double aspect : {0.5, 1.0, 4.0 / 3.0, 16.0 / 9.0, 3.0}) {
                const glm::dvec2 extent = extentIn(scene, view, aspect);
                EXPECT_NEAR(std::max(extent.x, extent.y), kFittedShare, 1e-6)
                    << size << ", aspect " << aspect;
            }
        }
    }
}

TEST(DefaultView, FewCornersFarAwayAreLeftOut) {
    Scene scene;
    const Index box = addBoxMesh(scene, "box", addMaterial(scene, {}));
    for (int i = 0; i < 30; ++i) place(scene, box, {3.0 * (i % 6), 0, 3.0 * (i / 6)}, 1.0);
    const DefaultView clean = defaultView(scene);
    place(scene, box, {1e5, 2e4, 0}, 1.0);
    EXPECT_EQ(defaultView(scene).position, clean.position);
    // Not if they are near enough to belong to the others.
    place(scene, box, {40, 0, 0}, 1.0);
    EXPECT_GT(glm::distance(defaultView(scene).position, clean.position), 5.0);
}

TEST(DefaultView, ACameraThatSeesNothingIsNotUsed) {
    Scene scene = boxScene();
    const Index away = addNode(scene, "away", glm::translate(glm::dmat4(1.0), {0, 0, -70}));
    scene.cameras.push_back({.node = away, .yfov = 0.5});  // the box is behind it
    EXPECT_NE(defaultView(scene).fit, glm::dvec2(0.0)) << "a fitted view";
    const Index inside = addNode(scene, "inside", glm::dmat4(1.0));
    scene.cameras.push_back({.node = inside, .yfov = 0.5});
    EXPECT_EQ(defaultView(scene).position, glm::dvec3(0.0)) << "it sees a box from its inside";
}

// A row of boxes that is ten times as long as what a default camera next to it shows.
TEST(DefaultView, ACameraOutsideThatSeesADetailIsNotUsed) {
    Scene scene;
    const Index box = addBoxMesh(scene, "box", addMaterial(scene, {}));
    for (int i = 0; i < 40; ++i) place(scene, box, {4.0 * i - 78.0, 0, 0}, 1.0);
    const Index near = addNode(scene, "near", glm::translate(glm::dmat4(1.0), {0, 0, 16}));
    scene.cameras = {{.node = near, .yfov = 0.8}};
    EXPECT_NE(defaultView(scene).fit, glm::dvec2(0.0)) << "4 of 40 boxes";
    const Index far = addNode(scene, "far", glm::translate(glm::dmat4(1.0), {0, 0, 60}));
    scene.cameras = {{.node = far, .yfov = 0.8}};
    EXPECT_EQ(defaultView(scene).position, glm::dvec3(0, 0, 60)) << "16 of 40";
    // Among the boxes it may see few of them.
    const Index among = addNode(scene, "among", glm::translate(glm::dmat4(1.0), {2, 0, 0.9}));
    scene.cameras = {{.node = among, .yfov = 0.8}};
    EXPECT_EQ(defaultView(scene).position, glm::dvec3(2, 0, 0.9));
}

// A box of 2 metres, 12 metres from the eye and in the middle of a frame that is as high as 4
// of them at that distance.
TEST(DefaultView, CoveredSharesAreThoseOfTheFrame) {
    Scene scene;
    place(scene, addBoxMesh(scene, "box", addMaterial(scene, {})), {0, 0, -13}, 1.0);
    const DefaultView view{{0, 0, 0}, {0, 0, -1}, 2.0 * std::atan(4.0 / 12.0)};
    EXPECT_DOUBLE_EQ(coveredShare(scene, poseAt(scene, 0.0), view), 1.0 / 16.0);
    EXPECT_EQ(coveredShare(scene, poseAt(scene, 0.0), {{0, 0, 0}, {0, 0, 1}, 1.0}), 0.0);
    EXPECT_EQ(coveredShare(scene, poseAt(scene, 0.0), {{0, 0, -13}, {1, 0, -12}, 1.0}), 1.0)
        << "inside";
}

TEST(DefaultView, IsTheFirstPerspectiveCamera) {
    Scene scene = boxScene();
    const Index node = addNode(scene, "eye", glm::translate(glm::dmat4(1.0), {0, 0, 7}));
    scene.cameras.push_back({.node = 0, .orthographic = true});
    scene.cameras.push_back({.node = node, .yfov = 0.5});
    const DefaultView view = defaultView(scene);
    EXPECT_EQ(view.position, glm::dvec3(0, 0, 7));
    EXPECT_NEAR(glm::length(view.target), 0.0, 1e-9);
    EXPECT_EQ(view.yfov, 0.5);
}

TEST(Scene, TheHashDependsOnContentNotOnTheId) {
    Scene a = boxScene(), b = boxScene();
    b.id = "another";
    updateContentHash(a);
    updateContentHash(b);
    EXPECT_EQ(a.contentHash, b.contentHash);
    b.materials[0].emissiveStrength = 2.0f;
    updateContentHash(b);
    EXPECT_NE(a.contentHash, b.contentHash);
}

// Changes one value of any kind that a material's table lists.
template <class T>
void change(T& value) {
    if constexpr (std::is_same_v<T, std::string>) {
        value += "x";
    } else if constexpr (std::is_same_v<T, bool>) {
        value = !value;
    } else if constexpr (std::is_enum_v<T>) {
        value = static_cast<T>(1);
    } else if constexpr (std::is_same_v<T, TextureSlot>) {
        value.texture = 0;
    } else if constexpr (std::is_same_v<T, MapBlur>) {
        value.size += 1;
    } else if constexpr (std::is_same_v<T, glm::dquat>) {
        value = glm::dquat(0.0, 1.0, 0.0, 0.0);
    } else {
        value *= 0.5f;
        value += T(0.3f);  // changes 0, 0.5 and 1
    }
}

TEST(Scene, EveryMaterialFieldChangesTheHash) {
    const std::uint64_t before = contentHash(Material{});
    int count = 0;
    const Material plain;
    fields(plain, [&](const char*, const auto&, const auto&) { ++count; });
    for (int changed = 0; changed < count; ++changed) {
        Material m;
        int i = 0;
        std::string name;
        fields(m, [&](const char* field, auto& member, const auto&) {
            if (i++ != changed) return;
            name = field;
            change(member);
        });
        EXPECT_NE(contentHash(m), before) << name;
        EXPECT_FALSE(m == Material{}) << name;
    }
}

struct Fault {
    const char* name;
    std::function<void(Scene&)> plant;
};
class SceneFault : public testing::TestWithParam<Fault> {};

Scene soundScene() {
    Scene scene = boxScene();
    TextureImage image{.width = 5, .height = 3, .texels = std::vector<std::uint8_t>(60, 200)};
    buildLevels(image);
    scene.images.push_back(image);
    scene.textures.push_back({.image = 0});
    scene.materials[0].baseColorTexture.texture = 0;
    scene.lights.push_back({.node = 0});
    scene.cameras.push_back({.node = 0});
    scene.probes.push_back({.name = "probe", .node = 0});
    return scene;
}

TEST(SceneProblems, FindsNoneInAValidScene) {
    EXPECT_THAT(sceneProblems(soundScene()), testing::IsEmpty());
}

TEST_P(SceneFault, IsDetected) {
    Scene scene = soundScene();
    GetParam().plant(scene);
    EXPECT_THAT(sceneProblems(scene), testing::Not(testing::IsEmpty()));
}

INSTANTIATE_TEST_SUITE_P(
    Planted, SceneFault,
    testing::Values(
        Fault{"nanVertex", [](Scene& s) { s.vertices[0].position.x = NAN; }},
        Fault{"infiniteColor", [](Scene& s) { s.vertices[0].color.x = INFINITY; }},
        Fault{"index", [](Scene& s) { s.indices[0] = 1u << 30; }},
        Fault{"clusterEnd", [](Scene& s) { s.clusters[0].indexCount = 39; }},
        Fault{"clusterOverflow", [](Scene& s) { s.clusters[0].firstIndex = 0xffffffffu; }},
        Fault{"meshClusters", [](Scene& s) { s.meshes[0].clusterCount = 0xffffffffu; }},
        Fault{"clusterWithoutEnd", [](Scene& s) { s.clusters[0].bounds.max.x = INFINITY; }},
        Fault{"clusterWithoutItsVertices",
              [](Scene& s) { s.clusters[0].bounds.max = s.clusters[0].bounds.min; }},
        Fault{"meshWithoutItsClusters", [](Scene& s) { s.meshes[0].bounds.min.y *= 0.5f; }},
        Fault{"nodeNowhere",
              [](Scene& s) { s.nodes.push_back({.parentFromLocal = glm::dmat4(1e200)}); }},
        Fault{"tooLarge", [](Scene& s) { s.nodes[0].parentFromLocal[0][0] = 1e20; }},
        Fault{"tooFarAway", [](Scene& s) { s.nodes[0].parentFromLocal[3][2] = -1e19; }},
        Fault{"reachWithoutEnd",
              [](Scene& s) { s.reach = {.min = glm::vec3(-1e30f), .max = glm::vec3(0.0f)}; }},
        Fault{"meshMaterial", [](Scene& s) { s.meshes[0].material = 7; }},
        Fault{"meshFlatParts", [](Scene& s) { s.meshes[0].firstFlatPart = 1; }},
        Fault{"meshFlatPartsOverflow", [](Scene& s) { s.meshes[0].firstFlatPart = 0xffffffffu; }},
        Fault{"meshArea", [](Scene& s) { s.meshes[0].area = NAN; }},
        Fault{"flatPartClusters", [](Scene& s) { s.flatParts[1].firstCluster = 0; }},
        Fault{"flatPartEnd", [](Scene& s) { s.flatParts[5].clusterCount = 0xffffffffu; }},
        Fault{"flatPartNormal", [](Scene& s) { s.flatParts[0].normal *= 2.0; }},
        Fault{"flatPartOffset", [](Scene& s) { s.flatParts[0].offset = INFINITY; }},
        Fault{"environmentRotation", [](Scene& s) { s.materials[0].environmentRotation.w = NAN; }},
        Fault{"imageMean", [](Scene& s) { s.images[0].mean.x = NAN; }},
        Fault{"instanceMaterial", [](Scene& s) { s.instances[0].material = 9; }},
        Fault{"probeNode", [](Scene& s) { s.probes[0].node = 7; }},
        Fault{"probeSize", [](Scene& s) { s.probes[0].size = 0.0; }},
        Fault{"meshTriangles", [](Scene& s) { s.meshes[0].primitives = 1; }},
        Fault{"texture", [](Scene& s) { s.materials[0].normalTexture.texture = 3; }},
        Fault{"image", [](Scene& s) { s.textures[0].image = 3; }},
        Fault{"imageSize", [](Scene& s) { s.images[0].width = 6; }},
        Fault{"imageLevels", [](Scene& s) { s.images[0].levels = 200; }},
        Fault{"roughness", [](Scene& s) { s.materials[0].roughness = 1.5f; }},
        Fault{"emission", [](Scene& s) { s.materials[0].emissiveStrength = -1.0f; }},
        Fault{"emissionOverflow",
              [](Scene& s) {
                  s.materials[0].emissive = glm::vec3(1e30f);
                  s.materials[0].emissiveStrength = 1e30f;
              }},
        Fault{"nodeParent", [](Scene& s) { s.nodes[0].parent = 0; }},
        Fault{"nodeMatrix", [](Scene& s) { s.nodes[0].parentFromLocal[2][1] = NAN; }},
        Fault{"instanceNode", [](Scene& s) { s.instances[0].node = 5; }},
        Fault{"instanceMesh", [](Scene& s) { s.instances[0].mesh = 5; }},
        Fault{"lightNode", [](Scene& s) { s.lights[0].node = 5; }},
        Fault{"cameraAngle", [](Scene& s) { s.cameras[0].yfov = 4.0; }},
        Fault{"defaultView", [](Scene& s) { s.defaultView = DefaultView{{1, 1, 1}, {1, 1, 1}}; }}),
    [](const auto& row) { return row.param.name; });

TextureImage picture(std::uint32_t width, std::uint32_t height, ColorSpace space,
                     const std::function<std::array<int, 4>(std::uint32_t, std::uint32_t)>& texel) {
    TextureImage image{.width = width, .height = height, .colorSpace = space};
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
            for (const int c : texel(x, y)) image.texels.push_back(static_cast<std::uint8_t>(c));
        }
    }
    buildLevels(image);
    return image;
}

// Requests name nodes, lights and cameras, so their names matter too.
TEST(SceneHash, DependsOnEveryMemberOfLightsCamerasNodesAndProbes) {
    Scene scene = boxScene();
    scene.lights.push_back({.name = "lamp", .node = 0});
    scene.cameras.push_back({.name = "door", .node = 0});
    scene.probes.push_back({.name = "middle"});
    updateContentHash(scene);
    std::set<std::uint64_t> hashes{scene.contentHash};
    const std::vector<std::function<void(Scene&)>> changes{
        [](Scene& s) { s.lights[0].name = "sun"; },
        [](Scene& s) { s.lights[0].node = kNone; },
        [](Scene& s) { s.lights[0].kind = LightKind::spot; },
        [](Scene& s) { s.lights[0].intensity.y = 2.0f; },
        [](Scene& s) { s.lights[0].range = 3.0f; },
        [](Scene& s) { s.lights[0].innerConeAngle = 0.1f; },
        [](Scene& s) { s.lights[0].outerConeAngle = 0.5f; },
        [](Scene& s) { s.lights[0].radius = 0.1f; },
        [](Scene& s) { s.lights[0].worldPosition = glm::dvec3(1.0); },
        [](Scene& s) { s.lights[0].worldDirection = glm::dvec3(1.0, 0.0, 0.0); },
        [](Scene& s) { s.cameras[0].name = "window"; },
        [](Scene& s) { s.cameras[0].yfov = 0.5; },
        [](Scene& s) { s.cameras[0].znear = 0.1; },
        [](Scene& s) { s.nodes[0].name = "root"; },
        [](Scene& s) { s.nodes[0].parentFromLocal[3].x = 1.0; },
        [](Scene& s) { s.nodes[0].visible = false; },
        [](Scene& s) { s.probes[0].name = "corner"; },
        [](Scene& s) { s.probes[0].size = 2.0; },
    };
    for (std::size_t i = 0; i < changes.size(); ++i) {
        Scene changed = scene;
        changes[i](changed);
        updateContentHash(changed);
        EXPECT_TRUE(hashes.insert(changed.contentHash).second) << "change " << i;
    }
}

TEST(ImageLevels, AChainEndsAtOneTexelForEverySize) {  // erratum R3
    for (const std::uint32_t n : {1u, 2u, 3u, 255u, 256u, 257u, 1080u}) {
        const TextureImage image = picture(n, 1, ColorSpace::linear, [](auto, auto) {
            return std::array{7, 7, 7, 255};
        });
        EXPECT_EQ(image.levels, static_cast<std::uint32_t>(std::floor(std::log2(n))) + 1);
        EXPECT_EQ(image.texels[image.texels.size() - 4], 7) << "a constant stays constant";
    }
}

TEST(ImageLevels, BlackAndWhiteMeetInLinearLight) {
    const auto checker = [](std::uint32_t x, std::uint32_t y) {
        const int c = (x + y) % 2 ? 255 : 0;
        return std::array{c, c, c, 255};
    };
    const TextureImage srgb = picture(4, 4, ColorSpace::srgb, checker);
    const TextureImage linear = picture(4, 4, ColorSpace::linear, checker);
    EXPECT_EQ(srgb.texels[64], 188);  // sRGB code of linear 0.5
    EXPECT_EQ(linear.texels[64], 128);
    EXPECT_FALSE(srgb.hasAlpha);
}

TEST(ImageLevels, EverySrgbCodeSurvivesAveragingWithItself) {
    for (int code = 0; code < 256; ++code) {
        const TextureImage image = picture(2, 2, ColorSpace::srgb, [&](auto, auto) {
            return std::array{code, code, code, code};
        });
        EXPECT_EQ(image.texels[16], code);
        EXPECT_EQ(image.hasAlpha, code != 255);
    }
}

}  // namespace
}  // namespace clerestory::test
