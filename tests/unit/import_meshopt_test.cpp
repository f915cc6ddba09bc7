// EXT_meshopt_compression: streams of the library's encoder give the same scene as plain files.
#include "tests/unit/compression_support.h"

#include <meshoptimizer.h>

namespace clerestory::test {
namespace {

using nlohmann::json;

std::string encodedVertices(const std::string& bytes, std::size_t stride) {
    const std::size_t count = bytes.size() / stride;
    std::string stream(meshopt_encodeVertexBufferBound(count, stride), '\0');
    meshopt_encodeVertexVersion(0);
    stream.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(stream.data()),
                                             stream.size(), bytes.data(), count, stride));
    return stream;
}

std::string encodedTriangles(const std::vector<std::uint32_t>& indices, std::size_t vertices) {
    std::string stream(meshopt_encodeIndexBufferBound(indices.size(), vertices), '\0');
    meshopt_encodeIndexVersion(1);
    stream.resize(meshopt_encodeIndexBuffer(reinterpret_cast<unsigned char*>(stream.data()),
                                            stream.size(), indices.data(), indices.size()));
    return stream;
}

std::string encodedSequence(const std::vector<std::uint32_t>& indices, std::size_t vertices) {
    std::string stream(meshopt_encodeIndexSequenceBound(indices.size(), vertices), '\0');
    meshopt_encodeIndexVersion(1);
    stream.resize(meshopt_encodeIndexSequence(reinterpret_cast<unsigned char*>(stream.data()),
                                              stream.size(), indices.data(), indices.size()));
    return stream;
}

// 2^-12 times a whole number in each component, which is exact for these positions: 8 bits for the
// exponent and 24 for the number.
std::string exponentialFilter(const std::vector<glm::vec3>& positions) {
    std::vector<std::uint32_t> words;
    for (const glm::vec3& p : positions) {
        for (int c = 0; c < 3; ++c) {
            const auto mantissa = static_cast<std::int32_t>(std::round(p[c] * 4096.0f));
            words.push_back(0xF4000000u | (static_cast<std::uint32_t>(mantissa) & 0xFFFFFFu));
        }
    }
    return bytesOf(words);
}

// A view of `count` elements that is only in the stream: its own buffer has no bytes.
int compressedView(GlbBuilder& builder, const std::string& stream, const char* mode,
                   std::size_t count, std::size_t stride, const char* filter = nullptr) {
    json& buffers = builder.json()["buffers"];
    if (buffers.size() == 1) {
        buffers.push_back({{"byteLength", 1 << 30},
                           {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}});
        builder.json()["extensionsRequired"] = {"EXT_meshopt_compression"};
    }
    json extension{{"buffer", 0},          {"byteOffset", builder.append(stream)},
                   {"count", count},       {"byteLength", stream.size()},
                   {"byteStride", stride}, {"mode", mode}};
    if (filter) extension["filter"] = filter;
    json view{{"buffer", 1},
              {"byteLength", count * stride},
              {"extensions", {{"EXT_meshopt_compression", extension}}}};
    if (std::string(mode) == "ATTRIBUTES") view["byteStride"] = stride;
    builder.json()["bufferViews"].push_back(view);
    return static_cast<int>(builder.json()["bufferViews"].size()) - 1;
}

// The order of a triangle's corners may be rotated by the encoder.
std::vector<std::uint32_t> decodedTriangles(const Surface& surface) {
    const std::string stream = encodedTriangles(surface.indices, surface.positions.size());
    std::vector<std::uint32_t> indices(surface.indices.size());
    EXPECT_EQ(meshopt_decodeIndexBuffer(indices.data(), indices.size(),
                                        reinterpret_cast<const unsigned char*>(stream.data()),
                                        stream.size()),
              0);
    return indices;
}

// How the parts of a surface are stored.
struct Storage {
    const char* name;
    const char* indexMode = "TRIANGLES";
    int indexType = kGltfUnsignedInt;
    const char* positionFilter = nullptr;
    int normalBits = 32;  // of a component: 8 and 16 are octahedral
    float normalError = 0.0f;
};

std::string compressedGlb(const Surface& surface, const Storage& storage) {
    GlbBuilder builder;
    const std::size_t count = surface.positions.size();
    std::string positions = bytesOf(surface.positions);
    if (storage.positionFilter) {
        positions = exponentialFilter(surface.positions);
    }
    const int positionView = compressedView(builder, encodedVertices(positions, 12), "ATTRIBUTES",
                                            count, 12, storage.positionFilter);
    int normals = 0;
    if (storage.normalBits < 32) {
        const std::size_t stride = static_cast<std::size_t>(storage.normalBits) / 2;
        std::vector<glm::vec4> wide;
        for (const glm::vec3& n : surface.normals) wide.emplace_back(n, 0.0f);
        std::string bytes(count * stride, '\0');
        meshopt_encodeFilterOct(bytes.data(), count, stride, storage.normalBits, &wide[0].x);
        const int view = compressedView(builder, encodedVertices(bytes, stride), "ATTRIBUTES",
                                        count, stride, "OCTAHEDRAL");
        normals = builder.accessor(view, storage.normalBits == 8 ? kGltfByte : kGltfShort, count,
                                   "VEC3", true);
    } else {
        const std::string stream = encodedVertices(bytesOf(surface.normals), 12);
        normals = builder.accessor(compressedView(builder, stream, "ATTRIBUTES", count, 12, "NONE"),
                                   kGltfFloat, count, "VEC3");
    }
    const int texCoords = compressedView(builder, encodedVertices(bytesOf(surface.texCoords), 8),
                                         "ATTRIBUTES", count, 8);
    const bool triangles = std::string(storage.indexMode) == "TRIANGLES";
    const int indices = compressedView(builder,
                                       triangles ? encodedTriangles(surface.indices, count)
                                                 : encodedSequence(surface.indices, count),
                                       storage.indexMode, surface.indices.size(),
                                       storage.indexType == kGltfUnsignedInt ? 4 : 2);
    builder.primitive()["attributes"] = {
        {"POSITION", builder.accessor(positionView, kGltfFloat, count, "VEC3")},
        {"NORMAL", normals},
        {"TEXCOORD_0", builder.accessor(texCoords, kGltfFloat, count, "VEC2")}};
    builder.primitive()["indices"] =
        builder.accessor(indices, storage.indexType, surface.indices.size(), "SCALAR");
    return builder.glb();
}

class MeshoptStorage : public testing::TestWithParam<Storage> {};

TEST_P(MeshoptStorage, IsThePlainMesh) {
    Surface surface = wavySurface(40);
    const Scene compressed = importedGlb(compressedGlb(surface, GetParam()));
    if (std::string(GetParam().indexMode) == "TRIANGLES") {
        surface.indices = decodedTriangles(surface);
    }
    const Scene plain = importedGlb(plainGlb(surface, GetParam().indexType));
    EXPECT_EQ(triangleCount(compressed), 3200u);
    const Difference most = difference(compressed, plain);
    EXPECT_EQ(most.position, 0.0f);
    EXPECT_EQ(most.texCoord, 0.0f);
    EXPECT_LE(most.normal, GetParam().normalError);
    EXPECT_TRUE(compressed.warnings.empty());
}

INSTANTIATE_TEST_SUITE_P(
    EveryModeAndFilter, MeshoptStorage,
    testing::Values(
        Storage{"triangles32"}, Storage{.name = "triangles16", .indexType = kGltfUnsignedShort},
        Storage{.name = "indices32", .indexMode = "INDICES"},
        Storage{.name = "indices16", .indexMode = "INDICES", .indexType = kGltfUnsignedShort},
        Storage{.name = "exponential", .positionFilter = "EXPONENTIAL"},
        // Half a step of 1/127 in each of two components, and of the rounded result.
        Storage{.name = "octahedral8", .normalBits = 8, .normalError = 0.02f},
        Storage{.name = "octahedral16", .normalBits = 16, .normalError = 1e-4f}),
    [](const auto& row) { return row.param.name; });

TEST(Meshopt, TrianglesKeepTheirCorners) {
    const Surface surface = wavySurface(20);
    const std::vector<std::uint32_t> decoded = decodedTriangles(surface);
    for (std::size_t i = 0; i < decoded.size(); i += 3) {
        const auto first = surface.indices.begin() + static_cast<std::ptrdiff_t>(i);
        std::vector<std::uint32_t> corners(first, first + 3);
        const auto start = std::find(corners.begin(), corners.end(), decoded[i]);
        ASSERT_NE(start, corners.end());
        std::rotate(corners.begin(), start, corners.end());
        EXPECT_TRUE(std::equal(corners.begin(), corners.end(), &decoded[i]));
    }
}

TEST(Meshopt, QuaternionsTurnInstances) {
    const Surface surface = wavySurface(2);
    std::vector<glm::vec4> rotations;
    for (int i = 0; i < 64; ++i) {
        const float a = 0.1f * static_cast<float>(i);
        rotations.push_back(
            glm::normalize(glm::vec4(std::sin(a), std::cos(3.0f * a), 0.5f, std::cos(a))));
    }
    std::string filtered(rotations.size() * 8, '\0');
    meshopt_encodeFilterQuat(filtered.data(), rotations.size(), 8, 16, &rotations[0].x);
    GlbBuilder builder;
    const int positions = builder.view(bytesOf(surface.positions)),
              indices = builder.view(bytesOf(surface.indices)),
              turns = compressedView(builder, encodedVertices(filtered, 8), "ATTRIBUTES",
                                     rotations.size(), 8, "QUATERNION");
    builder.primitive()["attributes"]["POSITION"] =
        builder.accessor(positions, kGltfFloat, surface.positions.size(), "VEC3");
    builder.primitive()["indices"] =
        builder.accessor(indices, kGltfUnsignedInt, surface.indices.size(), "SCALAR");
    const int rotation = builder.accessor(turns, kGltfShort, rotations.size(), "VEC4", true);
    builder.json()["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
        {"ROTATION", rotation}};
    const Scene scene = importedGlb(builder.glb());
    const Pose pose = poseAt(scene, 0.0);
    ASSERT_EQ(scene.instances.size(), rotations.size());
    for (std::size_t i = 0; i < rotations.size(); ++i) {
        const glm::vec4& q = rotations[i];
        const glm::dmat3 expected = glm::mat3_cast(glm::dquat(q.w, q.x, q.y, q.z));
        const glm::dmat3 actual(pose.worldFromNode[scene.instances[i].node]);
        for (int column = 0; column < 3; ++column) {
            EXPECT_LT(glm::distance(actual[column], expected[column]), 2e-4) << i;
        }
    }
}

// A small file whose position view can be changed.
std::string changed(const char* pointer, const json& value) {
    GlbBuilder builder;
    const Surface surface = wavySurface(4);
    const std::size_t count = surface.positions.size();
    const int positions = compressedView(builder, encodedVertices(bytesOf(surface.positions), 12),
                                         "ATTRIBUTES", count, 12);
    const int indices = compressedView(builder, encodedTriangles(surface.indices, count),
                                       "TRIANGLES", surface.indices.size(), 4);
    builder.primitive()["attributes"]["POSITION"] =
        builder.accessor(positions, kGltfFloat, count, "VEC3");
    builder.primitive()["indices"] =
        builder.accessor(indices, kGltfUnsignedInt, surface.indices.size(), "SCALAR");
    builder.json()[json::json_pointer(pointer)] = value;
    return builder.glb();
}

TEST(Meshopt, SizesAreCheckedBeforeDecoding) {
    const std::string positions = "/bufferViews/0/extensions/EXT_meshopt_compression/";
    const std::string indices = "/bufferViews/1/extensions/EXT_meshopt_compression/";
    const struct {
        std::string pointer;
        json value;
        const char* error;
    } rows[] = {
        {positions + "mode", "LINES", "malformed: buffer view 0 has an unknown meshopt mode"},
        {positions + "filter", "SHARP", "malformed: buffer view 0 has an unknown meshopt filter"},
        {positions + "filter", "OCTAHEDRAL",
         "malformed: buffer view 0 has a meshopt byteStride of 12; allowed is 4 or 8 with the "
         "filter OCTAHEDRAL"},
        {positions + "filter", "QUATERNION",
         "malformed: buffer view 0 has a meshopt byteStride of 12; allowed is 8 with the filter "
         "QUATERNION"},
        {positions + "byteStride", 0,
         "malformed: buffer view 0 has a meshopt byteStride of 0; allowed is a multiple of 4 up to "
         "256"},
        {positions + "byteStride", 260,
         "malformed: buffer view 0 has a meshopt byteStride of 260; allowed is a multiple of 4 up "
         "to 256"},
        {positions + "count", 1e15,
         "limit: buffer view 0 expands to 1000000000000000 elements of 12 bytes; allowed are "
         "536870912 bytes"},
        {positions + "count", 24,
         "malformed: buffer view 0 does not have the size of its decoded content, 24 elements of "
         "12 bytes"},
        {"/bufferViews/0/byteStride", 16,
         "malformed: buffer view 0 does not have the size of its decoded content, 25 elements of "
         "12 bytes"},
        {positions + "byteLength", 1e9, "malformed: buffer view 0 exceeds its buffer"},
        {positions + "byteLength", 20, "malformed: the meshopt stream of buffer view 0 is damaged"},
        {positions + "byteLength", 0, "malformed: the meshopt stream of buffer view 0 is damaged"},
        {positions + "buffer", 7, "malformed: buffers has no element 7"},
        {positions + "buffer", 1, "malformed: buffer 1 has no bytes"},
        {indices + "byteStride", 12,
         "malformed: buffer view 1 has a meshopt byteStride of 12; allowed is 2 or 4 for indices"},
        {indices + "filter", "EXPONENTIAL", "malformed: buffer view 1 has a filter on indices"},
        {indices + "count", 95,
         "malformed: buffer view 1 has 95 triangle indices, which is not a multiple of 3"},
        {"/bufferViews/0/extensions", json::object(), "malformed: buffer 1 has no bytes"},
    };
    EXPECT_EQ(errorOf(changed("/asset/generator", "test")), "was imported");
    for (const auto& row : rows) {
        EXPECT_EQ(errorOf(changed(row.pointer.c_str(), row.value)), row.error);
    }
}

TEST(Meshopt, ExpandedDataIsLimitedInTotal) {
    ImportLimits limits;
    limits.fileBytes = 100'000;
    const std::string zeros = encodedVertices(std::string(96'000, '\0'), 12);
    GlbBuilder builder;
    json& attributes = builder.primitive()["attributes"];
    for (const char* name : {"POSITION", "NORMAL", "COLOR_0", "TEXCOORD_0", "TEXCOORD_1"}) {
        const int view = compressedView(builder, zeros, "ATTRIBUTES", 8000, 12);
        attributes[name] = builder.accessor(view, kGltfFloat, 8000, "VEC3");
    }
    const std::string glb = builder.glb();
    ASSERT_LT(glb.size(), limits.fileBytes);
    EXPECT_EQ(errorOf(glb, limits), "limit: the compressed data expands to more than 400000 bytes");
}

TEST(Meshopt, DamagedStreamsDoNoHarm) {
    const Surface surface = wavySurface(12);
    const std::size_t count = surface.positions.size();
    const auto file = [&](const std::string& vertices, const std::string& indices, bool triangles) {
        GlbBuilder builder;
        const int positionView = compressedView(builder, vertices, "ATTRIBUTES", count, 12,
                                                triangles ? nullptr : "EXPONENTIAL");
        const int indexView = compressedView(builder, indices, triangles ? "TRIANGLES" : "INDICES",
                                             surface.indices.size(), 4);
        builder.primitive()["attributes"]["POSITION"] =
            builder.accessor(positionView, kGltfFloat, count, "VEC3");
        builder.primitive()["indices"] =
            builder.accessor(indexView, kGltfUnsignedInt, surface.indices.size(), "SCALAR");
        return builder.glb();
    };
    const std::string vertices = encodedVertices(bytesOf(surface.positions), 12),
                      triangles = encodedTriangles(surface.indices, count),
                      sequence = encodedSequence(surface.indices, count);
    expectNoCrash(vertices, 300, [&](const std::string& s) { return file(s, triangles, true); });
    expectNoCrash(vertices, 300, [&](const std::string& s) { return file(s, sequence, false); });
    expectNoCrash(triangles, 300, [&](const std::string& s) { return file(vertices, s, true); });
    expectNoCrash(sequence, 300, [&](const std::string& s) { return file(vertices, s, false); });
}

TEST(Meshopt, LoadTimes) {
    const Surface surface = wavySurface(400);
    reportLoadTimes("meshopt", compressedGlb(surface, {.name = "", .normalBits = 16}),
                    plainGlb(surface));
}

TEST(Meshopt, IngenuityLoads) {
    const auto file = sharedScene("IngenuityMeshopt/Ingenuity.glb");
    CLERESTORY_NEEDS(file);
    const Scene scene = importScene(file);
    EXPECT_GT(triangleCount(scene), 5'000u);
    const Bounds bounds = worldBounds(scene, poseAt(scene, 0.0));
    EXPECT_LT(glm::distance(bounds.min, bounds.max), 3.0f) << "a helicopter of 1.2 metres";
}

}  // namespace
}  // namespace clerestory::test
