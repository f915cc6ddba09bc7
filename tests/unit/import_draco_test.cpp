// KHR_draco_mesh_compression: meshes of the library's encoder give the same scene as plain files.
#include "tests/unit/compression_support.h"

#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

#include <array>
#include <utility>

namespace clerestory::test {
namespace {

using draco::GeometryAttribute;
using nlohmann::json;

struct Part {
    const char* semantic;
    GeometryAttribute::Type dracoType;
    draco::DataType dataType;
    std::int8_t components;
    int componentType;
    const char* type;
    bool normalized;
    std::string bytes;
    std::size_t count() const { return bytes.size() / bytesPerVertex(); }
    std::size_t bytesPerVertex() const {
        return static_cast<std::size_t>(draco::DataTypeLength(dataType) * components);
    }
};

std::vector<Part> floatParts(const Surface& s) {
    return {{"POSITION", GeometryAttribute::POSITION, draco::DT_FLOAT32, 3, kGltfFloat, "VEC3",
             false, bytesOf(s.positions)},
            {"NORMAL", GeometryAttribute::NORMAL, draco::DT_FLOAT32, 3, kGltfFloat, "VEC3", false,
             bytesOf(s.normals)},
            {"TEXCOORD_0", GeometryAttribute::TEX_COORD, draco::DT_FLOAT32, 2, kGltfFloat, "VEC2",
             false, bytesOf(s.texCoords)}};
}

// Unlike the index of the attribute in the stream.
unsigned uniqueId(std::size_t part) {
    return 7 + 10 * static_cast<unsigned>(part);
}

struct Encoding {
    draco::MeshEncoderMethod method = draco::MESH_SEQUENTIAL_ENCODING;
    int speed = 5;             // 0: the valence method of EdgeBreaker
    int quantizationBits = 0;  // 0: lossless
    bool metadata = false;
};

std::string encoded(const std::vector<Part>& parts, const std::vector<std::uint32_t>& indices,
                    const Encoding& encoding) {
    draco::Mesh mesh;
    mesh.set_num_points(static_cast<unsigned>(parts[0].count()));
    for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
        mesh.AddFace({draco::PointIndex(indices[i]), draco::PointIndex(indices[i + 1]),
                      draco::PointIndex(indices[i + 2])});
    }
    for (std::size_t p = 0; p < parts.size(); ++p) {
        const Part& part = parts[p];
        const auto stride = static_cast<std::int64_t>(part.bytesPerVertex());
        GeometryAttribute description;
        description.Init(part.dracoType, nullptr, static_cast<std::uint8_t>(part.components),
                         part.dataType, part.normalized, stride, 0);
        const int id = mesh.AddAttribute(description, true, static_cast<unsigned>(part.count()));
        for (std::uint32_t v = 0; v < part.count(); ++v) {
            mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v),
                                                  part.bytes.data() + v * part.bytesPerVertex());
        }
        mesh.attribute(id)->set_unique_id(uniqueId(p));
    }
    if (encoding.metadata) {
        auto metadata = std::make_unique<draco::GeometryMetadata>();
        metadata->AddEntryString("author", "a test");
        mesh.AddMetadata(std::move(metadata));
    }
    draco::ExpertEncoder encoder(mesh);
    encoder.SetEncodingMethod(encoding.method);
    encoder.SetSpeedOptions(encoding.speed, encoding.speed);
    for (int a = 0; encoding.quantizationBits > 0 && a < mesh.num_attributes(); ++a) {
        encoder.SetAttributeQuantization(a, encoding.quantizationBits);
    }
    draco::EncoderBuffer buffer;
    EXPECT_TRUE(encoder.EncodeToBuffer(&buffer).ok());
    return {buffer.data(), buffer.size()};
}

// A file of the encoded mesh, whose accessors lie in no buffer view.
GlbBuilder dracoFile(const std::vector<Part>& parts, std::size_t indices,
                     const std::string& stream) {
    GlbBuilder builder;
    builder.json()["extensionsRequired"] = {"KHR_draco_mesh_compression"};
    json& extension = builder.primitive()["extensions"]["KHR_draco_mesh_compression"];
    extension["bufferView"] = builder.view(stream);
    for (std::size_t p = 0; p < parts.size(); ++p) {
        const Part& part = parts[p];
        extension["attributes"][part.semantic] = uniqueId(p);
        builder.primitive()["attributes"][part.semantic] =
            builder.accessor(-1, part.componentType, part.count(), part.type, part.normalized);
    }
    builder.primitive()["indices"] = builder.accessor(-1, kGltfUnsignedInt, indices, "SCALAR");
    return builder;
}

GlbBuilder plainFile(const std::vector<Part>& parts, const std::vector<std::uint32_t>& indices) {
    GlbBuilder builder;
    for (const Part& part : parts) {
        builder.primitive()["attributes"][part.semantic] = builder.accessor(
            builder.view(part.bytes), part.componentType, part.count(), part.type, part.normalized);
    }
    builder.primitive()["indices"] = builder.accessor(builder.view(bytesOf(indices)),
                                                      kGltfUnsignedInt, indices.size(), "SCALAR");
    return builder;
}

GlbBuilder dracoFile(const Surface& surface, const Encoding& encoding = {}) {
    const std::vector<Part> parts = floatParts(surface);
    return dracoFile(parts, surface.indices.size(), encoded(parts, surface.indices, encoding));
}

TEST(Draco, SequentialMeshesAreExact) {
    const Surface surface = wavySurface(40);
    const Scene plain = importedGlb(plainGlb(surface));
    for (const bool metadata : {false, true}) {
        const Scene compressed = importedGlb(dracoFile(surface, {.metadata = metadata}).glb());
        const Difference most = difference(compressed, plain);
        EXPECT_EQ(triangleCount(compressed), 3200u);
        EXPECT_EQ(most.position, 0.0f);
        EXPECT_EQ(most.normal, 0.0f);
        EXPECT_EQ(most.texCoord, 0.0f);
        EXPECT_TRUE(compressed.warnings.empty());
    }
}

TEST(Draco, QuantizedMeshesAreWithinTheirSteps) {
    const Surface surface = wavySurface(40);
    const Scene plain = importedGlb(plainGlb(surface));
    const Difference most =
        difference(importedGlb(dracoFile(surface, {.quantizationBits = 12}).glb()), plain);
    EXPECT_GT(most.position, 0.0f);
    // The diagonal of half a step of 1/4095. For normals the diagonal of a step of 2/4095 in each
    // octahedral axis, stretched by at most the square root of 3 on the sphere.
    EXPECT_LT(most.position, 0.5f * 1.74f / 4095.0f + 1e-6f);
    EXPECT_LT(most.texCoord, 0.5f * 1.42f / 4095.0f + 1e-6f);
    EXPECT_LT(most.normal, 4.9f / 4095.0f);
}

// All triangles as corners of position, normal and texture coordinates, in a fixed order.
std::vector<std::array<float, 24>> sortedTriangles(const Scene& scene) {
    std::vector<std::array<float, 24>> triangles;
    for (std::size_t i = 0; i + 2 < scene.indices.size(); i += 3) {
        std::array<std::array<float, 8>, 3> corners;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vertex& v = scene.vertices[scene.indices[i + k]];
            corners[k] = {v.position.x, v.position.y, v.position.z,  v.normal.x,
                          v.normal.y,   v.normal.z,   v.texCoord0.x, v.texCoord0.y};
        }
        std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()),
                    corners.end());
        std::array<float, 24> triangle{};
        for (std::size_t k = 0; k < 24; ++k) triangle[k] = corners[k / 8][k % 8];
        triangles.push_back(triangle);
    }
    std::sort(triangles.begin(), triangles.end());
    return triangles;
}

// EdgeBreaker changes the order of triangles and vertices.
TEST(Draco, EdgeBreakerMeshesHaveTheSameTriangles) {
    const Surface surface = wavySurface(40);
    const auto expected = sortedTriangles(importedGlb(plainGlb(surface)));
    for (const int speed : {0, 5}) {
        const Encoding encoding{.method = draco::MESH_EDGEBREAKER_ENCODING, .speed = speed};
        const auto actual = sortedTriangles(importedGlb(dracoFile(surface, encoding).glb()));
        EXPECT_EQ(actual, expected) << speed;
    }
}

// Integers, colours and skins in the stream; morph targets next to it.
std::vector<Part> otherParts(const Surface& surface) {
    std::vector<std::array<std::int16_t, 3>> positions;
    std::vector<std::array<std::uint8_t, 4>> colors;
    std::vector<std::array<std::uint16_t, 4>> joints;
    std::vector<glm::vec4> weights;
    for (std::size_t i = 0; i < surface.positions.size(); ++i) {
        const glm::vec3 p = 32767.0f * surface.positions[i];
        positions.push_back({static_cast<std::int16_t>(p.x), static_cast<std::int16_t>(p.y),
                             static_cast<std::int16_t>(p.z)});
        const auto byte = static_cast<std::uint8_t>(i);
        colors.push_back({byte, static_cast<std::uint8_t>(255 - byte), 7, 255});
        joints.push_back({0, 1, 0, 0});
        weights.emplace_back(0.25f, 0.75f, 0.0f, 0.0f);
    }
    return {{"POSITION", GeometryAttribute::POSITION, draco::DT_INT16, 3, kGltfShort, "VEC3", true,
             bytesOf(positions)},
            {"COLOR_0", GeometryAttribute::COLOR, draco::DT_UINT8, 4, kGltfUnsignedByte, "VEC4",
             true, bytesOf(colors)},
            {"JOINTS_0", GeometryAttribute::GENERIC, draco::DT_UINT16, 4, kGltfUnsignedShort,
             "VEC4", false, bytesOf(joints)},
            {"WEIGHTS_0", GeometryAttribute::GENERIC, draco::DT_FLOAT32, 4, kGltfFloat, "VEC4",
             false, bytesOf(weights)}};
}

std::string moved(GlbBuilder builder, const Surface& surface) {
    const int target = builder.accessor(builder.view(bytesOf(surface.normals)), kGltfFloat,
                                        surface.normals.size(), "VEC3");
    builder.primitive()["targets"] = json::array({{{"POSITION", target}}});
    builder.json()["meshes"][0]["weights"] = {0.5};
    builder.json()["nodes"] = json::parse(R"([{"mesh": 0, "skin": 0}, {"translation": [1, 0, 0]},
                                              {"translation": [0, 0, 8]}])");
    builder.json()["scenes"][0]["nodes"] = {0, 1, 2};
    builder.json()["skins"] = json::parse(R"([{"joints": [1, 2]}])");
    return builder.glb();
}

TEST(Draco, IntegersColoursSkinsAndMorphTargets) {
    const Surface surface = wavySurface(12);
    const std::vector<Part> parts = otherParts(surface);
    const std::string stream = encoded(parts, surface.indices, {});
    const Scene plain = importedGlb(moved(plainFile(parts, surface.indices), surface));
    const Scene compressed =
        importedGlb(moved(dracoFile(parts, surface.indices.size(), stream), surface));
    const Difference most = difference(compressed, plain);
    EXPECT_EQ(most.position, 0.0f);
    EXPECT_EQ(most.color, 0.0f);
    EXPECT_GT(worldBounds(compressed, poseAt(compressed, 0.0)).min.z, 5.0f) << "moved by joint 1";
}

// Integers in the stream, floats in the accessor, and the other way round.
TEST(Draco, TheAccessorsDecideTheType) {
    const Surface surface = wavySurface(12);
    std::vector<Part> parts = otherParts(surface);
    parts.resize(2);
    const std::string stream = encoded(parts, surface.indices, {});
    const Scene integers = importedGlb(dracoFile(parts, surface.indices.size(), stream).glb());
    for (Part& part : parts) part.componentType = kGltfFloat;
    GlbBuilder builder = dracoFile(parts, surface.indices.size(), stream);
    for (json& accessor : builder.json()["accessors"]) accessor.erase("normalized");
    const Difference most = difference(importedGlb(builder.glb()), integers);
    EXPECT_LT(most.position, 1e-6f);
    EXPECT_LT(most.color, 1e-6f);
}

TEST(Draco, UncompressedAccessorsAreUsedUnlessItIsRequired) {
    const Surface surface = wavySurface(4);
    const std::vector<Part> parts = floatParts(surface);
    GlbBuilder builder = plainFile(parts, surface.indices);
    json& extension = builder.primitive()["extensions"]["KHR_draco_mesh_compression"];
    extension = {{"bufferView", builder.view("no Draco")},
                 {"attributes", {{"POSITION", 0}, {"NORMAL", 1}, {"TEXCOORD_0", 2}}}};
    EXPECT_EQ(triangleCount(importedGlb(builder.glb())), 32u);
    builder.json()["extensionsRequired"] = {"KHR_draco_mesh_compression"};
    EXPECT_EQ(errorOf(builder.glb()), "malformed: the Draco mesh in buffer view 4 is damaged");
}

TEST(Draco, SizesAreCheckedBeforeDecoding) {
    const Surface surface = wavySurface(4);
    const std::string name = "the Draco mesh in buffer view 0";
    const auto errorAfter = [&](const char* pointer, const json& value) {
        GlbBuilder builder = dracoFile(surface);
        builder.json()[json::json_pointer(pointer)] = value;
        return errorOf(builder.glb());
    };
    const std::string extension = "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression/";
    const struct {
        std::string pointer;
        json value;
        std::string error;
    } rows[] = {
        {"/accessors/3/count", 99,
         "malformed: " + name +
             " has 32 triangles, and the accessor of its indices has 99 elements"},
        {"/accessors/0/count", 26,
         "malformed: the accessors of " + name + " have different counts"},
        {"/accessors/0/count", 1e12, "limit: an accessor has too many elements"},
        {"/accessors/0/type", "VEC4",
         "malformed: attribute 7 of " + name +
             " has 25 elements of 3 components; its accessor has 25 of 4"},
        {"/accessors/0/componentType", 5121,
         "malformed: attribute 7 of " + name +
             " has values outside the range of its accessor's type"},
        {"/accessors/3/componentType", 5126,
         "malformed: the indices of " + name + " do not fit the type of their accessor"},
        {extension + "attributes/POSITION", 5,
         "malformed: attribute 5 of " + name + " does not exist"},
        {extension + "attributes/COLOR_0", 7,
         "malformed: " + name + " belongs to a primitive without an accessor of its attributes"},
        {extension + "bufferView", 3, "malformed: bufferViews has no element 3"},
    };
    for (const auto& row : rows) {
        EXPECT_EQ(errorAfter(row.pointer.c_str(), row.value), row.error) << row.pointer;
    }
    ImportLimits limits;
    limits.maxTriangles = 31;
    EXPECT_EQ(errorOf(dracoFile(surface).glb(), limits),
              "limit: " + name + " has 32 triangles; allowed are 31");
}

// A stream of a few bytes that declares billions of triangles or vertices.
TEST(Draco, HugeDeclarationsAreRejected) {
    const Surface surface = wavySurface(4);
    const std::vector<Part> parts = floatParts(surface);
    const std::string stream = encoded(parts, surface.indices, {});
    constexpr std::size_t kHeader = 11;  // bytes; the number of triangles and of points follow
    const std::string huge = "\xff\xff\xff\xff\x0f";
    const auto error = [&](const std::string& counts) {
        return errorOf(dracoFile(parts, surface.indices.size(),
                                 stream.substr(0, kHeader) + counts + stream.substr(kHeader + 2))
                           .glb());
    };
    EXPECT_EQ(error(huge + "\x19"),
              "limit: the Draco mesh in buffer view 0 has 4294967295 triangles; allowed are "
              "20000000");
    EXPECT_EQ(error("\x20" + huge),
              "malformed: the Draco mesh in buffer view 0 has 4294967295 vertices, and the "
              "accessors of its attributes have 25 elements");
    std::string old = stream;
    old[6] = 1;
    EXPECT_EQ(errorOf(dracoFile(parts, surface.indices.size(), old).glb()),
              "unsupported: the Draco mesh in buffer view 0 has version 2.1; supported is 2.2");
}

TEST(Draco, DamagedStreamsDoNoHarm) {
    const Surface surface = wavySurface(12);
    const std::vector<Part> parts = floatParts(surface);
    const auto file = [&](const std::string& stream) {
        return dracoFile(parts, surface.indices.size(), stream).glb();
    };
    for (const Encoding& encoding :
         {Encoding{.quantizationBits = 11},
          Encoding{.method = draco::MESH_EDGEBREAKER_ENCODING, .quantizationBits = 11},
          Encoding{.method = draco::MESH_EDGEBREAKER_ENCODING, .speed = 0, .quantizationBits = 8},
          Encoding{.metadata = true}}) {
        expectNoCrash(encoded(parts, surface.indices, encoding), 300, file);
    }
}

TEST(Draco, LoadTimes) {
    const Surface surface = wavySurface(400);
    const std::string plain = plainGlb(surface);
    reportLoadTimes("Draco, sequential", dracoFile(surface, {.quantizationBits = 14}).glb(), plain);
    for (const int speed : {5, 0}) {
        const Encoding encoding{
            .method = draco::MESH_EDGEBREAKER_ENCODING, .speed = speed, .quantizationBits = 14};
        reportLoadTimes(speed > 0 ? "Draco, EdgeBreaker" : "Draco, EdgeBreaker at its slowest",
                        dracoFile(surface, encoding).glb(), plain);
    }
}

TEST(Draco, TheChessBoardLoads) {
    const auto file = sharedScene("ChessBoardDraco/chess-board.glb");
    CLERESTORY_NEEDS(file);
    const Scene scene = importScene(file);
    EXPECT_EQ(triangleCount(scene), 178'848u - 3u) << "three triangles have no area";
    EXPECT_EQ(scene.instances.size(), 8u);
}

}  // namespace
}  // namespace clerestory::test
