// glTF: the scene contains what the file specifies.
#include "scene/import/base/json_fields.h"
#include "tests/unit/import_support.h"

#include <algorithm>

namespace clerestory {
namespace {

const Scene& everything() {
    static const Scene scene = importSceneInProcess(ownScene("everything.gltf"));
    return scene;
}

// A triangle whose JSON can be changed.
Json triangle() {
    return Json::parse(R"({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,)"
                       "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"
                       R"("}]})");
}

Scene imported(const Json& json) {
    const TemporaryFolder folder;
    return importSceneInProcess(folder.write("scene.gltf", json.dump()));
}

ImportError::Reason reasonFor(const Json& json) {
    try {
        imported(json);
    } catch (const ImportError& error) {
        return error.reason();
    }
    ADD_FAILURE() << "was imported";
    return ImportError::Reason::crashed;
}

// Files with each kind of compression, as this and other versions of the libraries write them.
TEST(Gltf, CompressedFilesLoadInTheChildProcess) {
    std::size_t files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(ownScene("../compressed"))) {
        SCOPED_TRACE(entry.path().filename().string());
        const Scene scene = importScene(entry.path());
        EXPECT_TRUE(scene.warnings.empty());
        EXPECT_GE(triangleCount(scene), 8u);
        ++files;
    }
    EXPECT_EQ(files, 10u);
}

TEST(Gltf, MaterialsKeepEveryProperty) {
    const Material& m = *material(everything(), "everything");
    EXPECT_EQ(m.baseColor, glm::vec4(0.5f, 0.25f, 0.125f, 0.75f));
    EXPECT_EQ(m.metallic, 0.25f);
    EXPECT_EQ(m.roughness, 0.5f);
    EXPECT_EQ(m.emissive, glm::vec3(1.0f, 0.5f, 0.0f));
    EXPECT_EQ(m.emissiveStrength, 16.0f);
    EXPECT_EQ(m.alphaMode, AlphaMode::mask);
    EXPECT_EQ(m.alphaCutoff, 0.3f);
    EXPECT_TRUE(m.doubleSided);
    EXPECT_EQ(m.extras, R"({"mirror":true})");
    EXPECT_EQ(m.ior, 1.33f);
    EXPECT_EQ(m.specular, 0.5f);
    EXPECT_EQ(m.specularColor, glm::vec3(1.0f, 0.5f, 0.5f));
    EXPECT_EQ(m.transmission, 0.9f);
    EXPECT_EQ(m.thickness, 0.1f);
    EXPECT_EQ(m.attenuationDistance, 0.0f) << "absent means that nothing is absorbed";
    EXPECT_EQ(m.baseColorTexture.offset, glm::vec2(0.5f, 0.25f));
    EXPECT_EQ(m.baseColorTexture.scale, glm::vec2(2.0f, 4.0f));
    EXPECT_EQ(m.baseColorTexture.rotation, 0.5f);
    EXPECT_TRUE(material(everything(), "plain")->unlit);
    EXPECT_EQ(material(everything(), "plain")->alphaMode, AlphaMode::opaque);
}

TEST(Gltf, TexturesAreDecodedOncePerColourSpace) {
    const Scene& scene = everything();
    const Material& m = *material(scene, "everything");
    ASSERT_EQ(scene.images.size(), 2u) << "one picture, as colour and as numbers";
    const Texture& color = scene.textures.at(m.baseColorTexture.texture);
    const Texture& numbers = scene.textures.at(m.metallicRoughnessTexture.texture);
    EXPECT_EQ(m.emissiveTexture.texture, m.baseColorTexture.texture);
    EXPECT_EQ(scene.images[color.image].colorSpace, ColorSpace::srgb);
    EXPECT_EQ(scene.images[numbers.image].colorSpace, ColorSpace::linear);
    EXPECT_EQ(color.wrapU, Wrap::clampToEdge);
    EXPECT_EQ(color.wrapV, Wrap::mirroredRepeat);
    EXPECT_EQ(color.magnify, Filter::nearest);
    EXPECT_FALSE(color.useLevels);
    EXPECT_EQ(numbers.wrapU, Wrap::repeat);
    EXPECT_TRUE(numbers.useLevels);

    const TextureImage& image = scene.images[color.image];
    EXPECT_EQ(image.width, 2u);
    EXPECT_EQ(image.levels, 2u);
    EXPECT_TRUE(image.hasAlpha);
    const std::vector<std::uint8_t> topRow(image.texels.begin(), image.texels.begin() + 8);
    EXPECT_EQ(topRow, (std::vector<std::uint8_t>{255, 0, 0, 255, 0, 255, 0, 255}));
}

TEST(Gltf, AMissingImageIsAWarning) {
    EXPECT_FALSE(material(everything(), "lost")->normalTexture.present());
    ASSERT_TRUE(warning(everything(), "missingTexture"));
    EXPECT_EQ(warning(everything(), "missingTexture")->subject, "no such.png");
}

TEST(Gltf, NodesKeepTransformAndHandedness) {
    const Scene& scene = everything();
    const Pose pose = poseAt(scene, 0.0);
    const glm::dmat4& quad = pose.worldFromNode.at(scene.instances.at(0).node);
    // Scaled by (-1, 2, 3), turned by 90 degrees about z, moved by 10 along x.
    const glm::dvec4 corner = quad * glm::dvec4(1, 1, 1, 1);
    EXPECT_NEAR(corner.x, 8.0, 1e-12);
    EXPECT_NEAR(corner.y, -1.0, 1e-12);
    EXPECT_NEAR(corner.z, 3.0, 1e-12);
    EXPECT_LT(glm::determinant(glm::dmat3(quad)), 0.0) << "mirrored stays mirrored";
    EXPECT_TRUE(warning(scene, "singularTransform"));
    for (const Instance& instance : scene.instances) {
        EXPECT_NE(scene.nodes[instance.node].name, "flat");
    }
}

TEST(Gltf, CamerasAndLights) {
    const Scene& scene = everything();
    ASSERT_EQ(scene.cameras.size(), 2u);
    EXPECT_DOUBLE_EQ(scene.cameras[0].yfov, 0.7);
    EXPECT_DOUBLE_EQ(scene.cameras[0].zfar, 0.0) << "absent means infinite";
    EXPECT_TRUE(scene.cameras[1].orthographic);
    EXPECT_DOUBLE_EQ(scene.cameras[1].yHalfHeight, 2.0);
    ASSERT_EQ(scene.lights.size(), 3u);
    EXPECT_EQ(scene.lights[0].intensity, glm::vec3(40.0f, 20.0f, 10.0f));
    EXPECT_EQ(scene.lights[0].range, 8.0f);
    EXPECT_EQ(scene.lights[1].kind, LightKind::spot);
    EXPECT_EQ(scene.lights[1].outerConeAngle, 0.6f);
    EXPECT_EQ(scene.lights[2].kind, LightKind::directional);
    EXPECT_EQ(scene.lights[2].intensity, glm::vec3(3.0f));
}

TEST(Gltf, StripsAndFansBecomeTriangles) {
    const Scene& scene = everything();
    // Two from the quad; three vertices of four make one; a strip of four makes two.
    EXPECT_EQ(triangleCount(scene), 5u);
    EXPECT_EQ(primitiveCount(scene, Primitive::lines), 2u) << "of four vertices";
    // Every triangle of the flat quad looks along +z, the strip's second one too.
    for (const Vertex& v : scene.vertices) {
        EXPECT_NEAR(v.normal.z, 1.0f, 1e-6f);
    }
}

TEST(Gltf, MissingMaterialsUseTheDefault) {
    const Scene scene = imported(triangle());
    const Material& m = scene.materials.at(scene.meshes.at(0).material);
    EXPECT_EQ(m.metallic, 1.0f);
    EXPECT_EQ(m.roughness, 1.0f);
    EXPECT_EQ(m.baseColor, glm::vec4(1.0f));
    EXPECT_EQ(scene.title, "scene");
}

TEST(Gltf, SkinnedMeshesFollowTheirJoints) {
    Json json = triangle();
    // Every vertex belongs to joint 0 (an accessor of zeros) with weights 1, 0, 0, 0.
    json["buffers"].push_back(
        {{"byteLength", 48},
         {"uri",
          "data:application/octet-stream;base64,"
          "AACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAAAA"}});
    json["bufferViews"].push_back({{"buffer", 1}, {"byteLength", 48}});
    json["accessors"].push_back({{"componentType", 5121}, {"count", 3}, {"type", "VEC4"}});
    json["accessors"].push_back(
        {{"bufferView", 1}, {"componentType", 5126}, {"count", 3}, {"type", "VEC4"}});
    json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = 1;
    json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = 2;
    json["nodes"] = Json::parse(R"([{"mesh": 0, "skin": 0, "translation": [100, 0, 0]},
                                    {"translation": [0, 0, 7]}])");
    json["scenes"][0]["nodes"] = {0, 1};
    json["skins"] = Json::parse(R"([{"joints": [1]}])");
    const Scene scene = imported(json);
    const Bounds bounds = worldBounds(scene, poseAt(scene, 0.0));
    EXPECT_EQ(bounds.min, glm::vec3(0.0f, 0.0f, 7.0f)) << "not at the mesh's own node";
    EXPECT_EQ(bounds.max, glm::vec3(1.0f, 1.0f, 7.0f));
}

// Half of the weight is in the second set of each vertex.
TEST(Gltf, EightJointsMoveAVertexAtRest) {
    Json json = triangle();
    const auto add = [&](std::size_t bytes, const char* base64, int type) {
        json["buffers"].push_back(
            {{"byteLength", bytes},
             {"uri", std::string("data:application/octet-stream;base64,") + base64}});
        json["bufferViews"].push_back(
            {{"buffer", json["buffers"].size() - 1}, {"byteLength", bytes}});
        json["accessors"].push_back({{"bufferView", json["bufferViews"].size() - 1},
                                     {"componentType", type},
                                     {"count", 3},
                                     {"type", "VEC4"}});
        return json["accessors"].size() - 1;
    };
    auto& attributes = json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = add(12, "AAAAAAAAAAAAAAAA", 5121);
    attributes["JOINTS_1"] = add(12, "AQAAAAEAAAABAAAA", 5121);
    attributes["WEIGHTS_0"] = attributes["WEIGHTS_1"] =
        add(48, "AACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAAAA", 5126);
    json["nodes"] = Json::parse(
        R"([{"mesh": 0, "skin": 0}, {"translation": [0, 0, 7]}, {"translation": [0, 0, 9]}])");
    json["scenes"][0]["nodes"] = {0, 1, 2};
    json["skins"] = Json::parse(R"([{"joints": [1, 2]}])");
    const Scene scene = imported(json);
    EXPECT_EQ(worldBounds(scene, poseAt(scene, 0.0)).min.z, 8.0f);
}

TEST(Gltf, TheLimitCountsTheTrianglesOfAllInstances) {
    Json json = triangle();
    json["nodes"] = Json::parse(R"([{"mesh": 0}, {"mesh": 0}, {"mesh": 0}])");
    json["scenes"][0]["nodes"] = {0, 1, 2};
    const TemporaryFolder folder;
    const auto file = folder.write("scene.gltf", json.dump());
    EXPECT_EQ(importSceneInProcess(file, {.maxDrawn = 3}).instances.size(), 3u);
    EXPECT_THROW(importSceneInProcess(file, {.maxDrawn = 2}), ImportError);
}

TEST(Gltf, CamerasWithoutANameHaveThatOfTheirNode) {
    Json json = triangle();
    json["cameras"] = Json::parse(R"([{"type": "perspective", "perspective": {"yfov": 0.5}}])");
    json["nodes"].push_back({{"name", "door"}, {"camera", 0}});
    json["scenes"][0]["nodes"] = {0, 1};
    EXPECT_EQ(imported(json).cameras.at(0).name, "door");
}

TEST(Gltf, AnIndexOfRefractionOfZeroReflectsNearlyEverything) {
    Json json = triangle();
    json["materials"] = Json::parse(R"([{"extensions": {"KHR_materials_ior": {"ior": 0}}}])");
    json["meshes"][0]["primitives"][0]["material"] = 0;
    const Scene scene = imported(json);
    const float r = (scene.materials.at(0).ior - 1.0f) / (scene.materials.at(0).ior + 1.0f);
    EXPECT_GT(r * r, 0.95f);
    EXPECT_FALSE(warning(scene, "materialOutOfRange"));
}

TEST(Gltf, FilesOfALaterVersionAreRefused) {
    Json json = triangle();
    json["asset"]["minVersion"] = "2.0";
    EXPECT_EQ(imported(json).instances.size(), 1u);
    json["asset"]["minVersion"] = "2.1";
    EXPECT_EQ(reasonFor(json), ImportError::Reason::unsupported);
}

TEST(Gltf, MorphWeightsOfTheFileAreApplied) {
    Json json = triangle();
    json["meshes"][0]["primitives"][0]["targets"] = Json::parse(R"([{"POSITION": 0}])");
    json["meshes"][0]["weights"] = {0.5};
    const Scene scene = imported(json);
    EXPECT_EQ(worldBounds(scene, poseAt(scene, 0.0)).max, glm::vec3(1.5f, 1.5f, 0.0f));
}

TEST(Gltf, InvalidFilesAreRejectedByName) {
    const auto changed = [](const char* pointer, const Json& value) {
        Json json = triangle();
        json[Json::json_pointer(pointer)] = value;
        return json;
    };
    using Reason = ImportError::Reason;
    const struct {
        const char* what;
        Json json;
        Reason reason;
    } cases[] = {
        {"version 1", changed("/asset/version", "1.0"), Reason::unsupported},
        {"DDS", changed("/extensionsRequired", {"MSFT_texture_dds"}), Reason::unsupported},
        {"a node its own child", changed("/nodes/0/children", {0}), Reason::malformed},
        {"no such node", changed("/scenes/0/nodes", {9}), Reason::malformed},
        {"a negative index", changed("/scenes/0/nodes", {-1}), Reason::malformed},
        {"no such mesh", changed("/nodes/0/mesh", 1), Reason::malformed},
        {"no such material", changed("/meshes/0/primitives/0/material", 0), Reason::malformed},
        {"a text for a number", changed("/accessors/0/count", "three"), Reason::malformed},
        {"half a vertex", changed("/accessors/0/count", 2.5), Reason::malformed},
        {"too many vertices", changed("/accessors/0/count", 4), Reason::malformed},
        {"a huge count", changed("/accessors/0/count", 1e15), Reason::limit},
        {"beyond its buffer", changed("/bufferViews/0/byteOffset", 1), Reason::malformed},
        {"a huge stride", changed("/bufferViews/0/byteStride", 1e15), Reason::malformed},
        {"a short buffer", changed("/buffers/0/byteLength", 37), Reason::malformed},
        {"not base64", changed("/buffers/0/uri", "data:;base64,!!!"), Reason::malformed},
        {"a missing buffer", changed("/buffers/0/uri", "no.bin"), Reason::malformed},
        {"a matrix of 15",
         changed("/nodes/0/matrix", Json::array({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0})),
         Reason::malformed},
        {"nothing to draw", changed("/nodes/0", Json::object()), Reason::unsupported},
    };
    for (const auto& c : cases) {
        EXPECT_EQ(reasonFor(c.json), c.reason) << c.what;
    }
}

TEST(Gltf, ExponentialNodeGraphsAreRejected) {
    Json json = triangle();
    json["nodes"] = Json::array();
    for (int i = 0; i < 40; ++i) {
        json["nodes"].push_back({{"children", {i + 1, i + 1}}});  // 2^40 paths
    }
    json["nodes"].push_back({{"mesh", 0}});
    EXPECT_EQ(reasonFor(json), ImportError::Reason::malformed);
}

TEST(Gltf, DeepTreesAndDeepJson) {
    Json json = triangle();
    json["nodes"] = Json::array();
    for (int i = 0; i < 20000; ++i) {
        json["nodes"].push_back({{"children", {i + 1}}});
    }
    json["nodes"].push_back({{"mesh", 0}});
    EXPECT_EQ(triangleCount(imported(json)), 1u);

    const TemporaryFolder folder;
    const std::string deep =
        "{\"extras\":" + std::string(200000, '[') + std::string(200000, ']') + "}";
    EXPECT_EQ(refusal(folder.write("deep.gltf", deep)).reason(), ImportError::Reason::malformed);
}

TEST(Gltf, LimitsApply) {
    const TemporaryFolder folder;
    Json json = triangle();
    json["nodes"].push_back({{"mesh", 0}});
    json["scenes"][0]["nodes"] = {0, 1};
    const auto file = folder.write("two.gltf", json.dump());
    ImportLimits limits;
    limits.maxNodes = 1;
    EXPECT_THROW(importSceneInProcess(file, limits), ImportError);
    limits = {};
    limits.maxTriangles = 0;
    EXPECT_THROW(importSceneInProcess(file, limits), ImportError);
    limits = {};
    limits.fileBytes = 100;
    EXPECT_THROW(importSceneInProcess(file, limits), ImportError);
    EXPECT_NO_THROW(importSceneInProcess(file));
}

// Erratum P1: a flattened mirror still mirrors.
TEST(Gltf, FlatteningNodesKeepTheirMesh) {
    const float corners[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0};
    const TemporaryFolder folder;
    folder.write("quad.bin", {reinterpret_cast<const char*>(corners), sizeof corners});
    const Scene scene = importSceneInProcess(folder.write("quad.gltf", R"({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 2]}],
        "nodes": [{"scale": [200, 200, 200], "rotation": [0.6, 0, 0, 0.8], "children": [1]},
                  {"name": "flat", "mesh": 0, "scale": [2, 3, 0], "translation": [0, 0, 1]},
                  {"name": "mirrored", "mesh": 0, "scale": [-1, 0, 1],
                   "rotation": [0.7071067811865476, 0, 0, 0.7071067811865476]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 6, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 72}],
        "buffers": [{"byteLength": 72, "uri": "quad.bin"}]})"));
    EXPECT_EQ(warning(scene, "singularTransform"), nullptr);
    ASSERT_EQ(scene.instances.size(), 2u);
    ASSERT_EQ(scene.flatParts.size(), 1u);
    const Pose pose = poseAt(scene, 0.0);
    const glm::dmat4& world = pose.worldFromNode[scene.instances[0].node];
    EXPECT_GT(glm::determinant(glm::dmat3(world)), 0.0);
    EXPECT_TRUE(std::isfinite(glm::inverse(world)[2][2]));
    const auto plane = transformed(scene.flatParts[0].plane(), world);
    ASSERT_TRUE(plane);
    const glm::dvec3 across = glm::normalize(glm::dvec3(pose.worldFromNode[0][2]));
    EXPECT_NEAR(glm::dot(plane->normal, across), 1.0, 1e-9) << "its front stays its front";
    EXPECT_NEAR(glm::distance(glm::dvec3(world * glm::dvec4(1, 1, 0, 1)),
                              glm::dvec3(pose.worldFromNode[0] * glm::dvec4(2, 3, 1, 1))),
                0.0, 1e-9);
}

}  // namespace
}  // namespace clerestory
