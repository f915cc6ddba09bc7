// Compressed glTF: what is read equals the plain form; damaged streams and wrong sizes give one
// clear reason. The encoders are those of the libraries, which are not what is tested here.
#include "import_support.h"
#include "tests/support/scene_files.h"

#include "scene/import/gltf/compression.h"
#include "scene/import/in_process.h"

#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>
#include <gmock/gmock.h>
#include <meshoptimizer.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <random>

namespace clerestory::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

// A curved sheet of n x n squares.
struct Sheet {
    std::vector<glm::vec3> positions, normals;
    std::vector<glm::vec2> texCoords;
    std::vector<std::uint32_t> indices;
};

Sheet sheetOf(std::uint32_t n) {
    Sheet sheet;
    for (std::uint32_t y = 0; y <= n; ++y) {
        for (std::uint32_t x = 0; x <= n; ++x) {
            const float u = static_cast<float>(x) / static_cast<float>(n);
            const float v = static_cast<float>(y) / static_cast<float>(n);
            sheet.positions.emplace_back(u, v, 0.2f * std::sin(7.0f * u * v));
            sheet.normals.push_back(glm::normalize(glm::vec3(-u, -v, 3.0f)));
            sheet.texCoords.emplace_back(u, 1.0f - v);
        }
    }
    for (std::uint32_t y = 0; y < n; ++y) {
        for (std::uint32_t x = 0; x < n; ++x) {
            const std::uint32_t a = y * (n + 1) + x, b = a + n + 1;
            for (const std::uint32_t i : {a, a + 1, b, b, a + 1, b + 1}) sheet.indices.push_back(i);
        }
    }
    return sheet;
}

template <class T>
std::string bytesOf(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

// Accessors 0 to 3: positions, normals, texture coordinates, indices.
json documentOf(const Sheet& sheet) {
    const std::size_t vertices = sheet.positions.size();
    const auto accessor = [&](int view, std::size_t count, const char* type, int component) {
        return json{
            {"bufferView", view}, {"count", count}, {"type", type}, {"componentType", component}};
    };
    return {
        {"asset", {{"version", "2.0"}}},
        {"scenes", {{{"nodes", {0}}}}},
        {"nodes", {{{"mesh", 0}}}},
        {"meshes",
         {{{"name", "sheet"},
           {"primitives",
            {{{"attributes", {{"POSITION", 0}, {"NORMAL", 1}, {"TEXCOORD_0", 2}}},
              {"indices", 3}}}}}}},
        {"accessors",
         {accessor(0, vertices, "VEC3", 5126), accessor(1, vertices, "VEC3", 5126),
          accessor(2, vertices, "VEC2", 5126), accessor(3, sheet.indices.size(), "SCALAR", 5125)}},
        {"bufferViews", json::array()}};
}

std::string plainGlb(const Sheet& sheet) {
    json document = documentOf(sheet);
    std::string binary;
    for (const std::string& part : {bytesOf(sheet.positions), bytesOf(sheet.normals),
                                    bytesOf(sheet.texCoords), bytesOf(sheet.indices)}) {
        document["bufferViews"].push_back(
            {{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", part.size()}});
        binary += part;
    }
    document["buffers"] = {{{"byteLength", binary.size()}}};
    return glbOf(document.dump(), binary);
}

std::string encodedVertices(const std::string& bytes, std::size_t stride) {
    const std::size_t count = bytes.size() / stride;
    std::string out(meshopt_encodeVertexBufferBound(count, stride), '\0');
    auto* const to = reinterpret_cast<unsigned char*>(out.data());
    out.resize(meshopt_encodeVertexBuffer(to, out.size(), bytes.data(), count, stride));
    return out;
}

std::string encodedTriangles(const std::vector<std::uint32_t>& indices, std::size_t vertices) {
    std::string out(meshopt_encodeIndexBufferBound(indices.size(), vertices), '\0');
    auto* const to = reinterpret_cast<unsigned char*>(out.data());
    out.resize(meshopt_encodeIndexBuffer(to, out.size(), indices.data(), indices.size()));
    return out;
}

// With a fallback buffer without bytes, as encoders write it. `change` may damage the document.
std::string meshoptGlb(const Sheet& sheet, const std::function<void(json&)>& change = {}) {
    json document = documentOf(sheet);
    document["extensionsRequired"] = document["extensionsUsed"] = {"EXT_meshopt_compression"};
    std::string binary;
    std::size_t fallback = 0;
    const auto add = [&](const std::string& plain, const std::string& encoded, std::size_t stride,
                         const char* mode) {
        document["bufferViews"].push_back({{"buffer", 1},
                                           {"byteOffset", fallback},
                                           {"byteLength", plain.size()},
                                           {"extensions",
                                            {{"EXT_meshopt_compression",
                                              {{"buffer", 0},
                                               {"byteOffset", binary.size()},
                                               {"byteLength", encoded.size()},
                                               {"byteStride", stride},
                                               {"count", plain.size() / stride},
                                               {"mode", mode}}}}}});
        fallback += plain.size();
        binary += encoded;
        binary.resize((binary.size() + 3) / 4 * 4);
    };
    const std::string positions = bytesOf(sheet.positions), normals = bytesOf(sheet.normals),
                      texCoords = bytesOf(sheet.texCoords);
    add(positions, encodedVertices(positions, 12), 12, "ATTRIBUTES");
    add(normals, encodedVertices(normals, 12), 12, "ATTRIBUTES");
    add(texCoords, encodedVertices(texCoords, 8), 8, "ATTRIBUTES");
    add(bytesOf(sheet.indices), encodedTriangles(sheet.indices, sheet.positions.size()), 4,
        "TRIANGLES");
    document["buffers"] = {{{"byteLength", binary.size()}}, {{"byteLength", fallback}}};
    if (change) change(document);
    return glbOf(document.dump(), binary);
}

std::string dracoGlb(const Sheet& sheet, const std::function<void(json&)>& change = {}) {
    draco::Mesh mesh;
    const auto vertices = static_cast<std::uint32_t>(sheet.positions.size());
    mesh.set_num_points(vertices);
    const auto add = [&](draco::GeometryAttribute::Type type, std::int8_t components,
                         const float* values) {
        draco::GeometryAttribute format;
        format.Init(type, nullptr, components, draco::DT_FLOAT32, false,
                    static_cast<std::int64_t>(components * sizeof(float)), 0);
        const int id = mesh.AddAttribute(format, true, vertices);
        for (std::uint32_t i = 0; i < vertices; ++i) {
            mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i),
                                                  values + i * static_cast<unsigned>(components));
        }
        return mesh.attribute(id)->unique_id();
    };
    const auto position = add(draco::GeometryAttribute::POSITION, 3, &sheet.positions[0].x);
    const auto normal = add(draco::GeometryAttribute::GENERIC, 3, &sheet.normals[0].x);
    const auto texCoord = add(draco::GeometryAttribute::TEX_COORD, 2, &sheet.texCoords[0].x);
    for (std::size_t i = 0; i < sheet.indices.size(); i += 3) {
        mesh.AddFace({draco::PointIndex(sheet.indices[i]), draco::PointIndex(sheet.indices[i + 1]),
                      draco::PointIndex(sheet.indices[i + 2])});
    }
    draco::Encoder encoder;  // without quantization: exact
    encoder.SetTrackEncodedProperties(true);
    draco::EncoderBuffer out;
    EXPECT_TRUE(encoder.EncodeMeshToBuffer(mesh, &out).ok());
    json document = documentOf(sheet);
    document["extensionsRequired"] = document["extensionsUsed"] = {"KHR_draco_mesh_compression"};
    for (json& accessor : document["accessors"]) accessor.erase("bufferView");
    for (int i = 0; i < 3; ++i) document["accessors"][i]["count"] = encoder.num_encoded_points();
    document["bufferViews"] = {{{"buffer", 0}, {"byteLength", out.size()}}};
    document["buffers"] = {{{"byteLength", out.size()}}};
    document["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = {
        {"bufferView", 0},
        {"attributes", {{"POSITION", position}, {"NORMAL", normal}, {"TEXCOORD_0", texCoord}}}};
    if (change) change(document);
    return glbOf(document.dump(), {out.data(), out.size()});
}

// Each from its least corner, in order: decoders may turn triangles and sort vertices.
using Corner = std::array<float, 8>;
std::vector<std::array<Corner, 3>> trianglesOf(const Scene& scene) {
    std::vector<std::array<Corner, 3>> triangles;
    for (std::size_t i = 0; i + 2 < scene.indices.size(); i += 3) {
        std::array<Corner, 3> triangle;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vertex& v = scene.vertices[scene.indices[i + k]];
            triangle[k] = {v.position.x, v.position.y, v.position.z,  v.normal.x,
                           v.normal.y,   v.normal.z,   v.texCoord0.x, v.texCoord0.y};
        }
        std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()),
                    triangle.end());
        triangles.push_back(triangle);
    }
    std::sort(triangles.begin(), triangles.end());
    return triangles;
}

class Compression : public testing::Test {
protected:
    Scene sceneOf(const std::string& glb) {
        return importSceneInProcess(folder_.write("scene.glb", glb));
    }
    ImportError refusalOf(const std::string& glb) {
        try {
            sceneOf(glb);
        } catch (const ImportError& error) {
            return error;
        }
        ADD_FAILURE() << "it was read";
        return {ImportError::Reason::crashed, ""};
    }
    TemporaryFolder folder_;
};

TEST_F(Compression, AScenesTrianglesAreThoseOfThePlainForm) {
    const Sheet sheet = sheetOf(23);
    const auto plain = trianglesOf(sceneOf(plainGlb(sheet)));
    ASSERT_EQ(plain.size(), 2u * 23u * 23u);
    EXPECT_EQ(trianglesOf(sceneOf(meshoptGlb(sheet))), plain);
    EXPECT_EQ(trianglesOf(sceneOf(dracoGlb(sheet))), plain);
}

// Values of the three filters by their definitions in the extension's specification.
TEST_F(Compression, FiltersOfMeshoptAreTheirDefinitions) {
    constexpr std::size_t kCount = 100;
    std::mt19937 random(7);
    const auto decoded = [&](const std::string& bytes, std::size_t stride, const char* filter) {
        const std::string encoded = encodedVertices(bytes, stride);
        return decodedMeshopt(
            {.count = kCount, .stride = stride, .mode = "ATTRIBUTES", .filter = filter},
            {reinterpret_cast<const unsigned char*>(encoded.data()), encoded.size()}, "view");
    };
    std::string any(kCount * 8, '\0');
    for (char& c : any) c = static_cast<char>(random());
    EXPECT_EQ(decoded(any, 8, "NONE"), any);
    EXPECT_EQ(decoded(any, 8, ""), any);

    // The exponent in the upper 8 bits, the mantissa in the lower 24, both signed.
    std::vector<std::int32_t> numbers;
    for (std::size_t i = 0; i < 2 * kCount; ++i) {
        const auto exponent = static_cast<std::int32_t>(random() % 40) - 30;
        const auto mantissa = static_cast<std::int32_t>(random() % 0x1000000) - 0x800000;
        numbers.push_back(
            static_cast<std::int32_t>(static_cast<std::uint32_t>(exponent) << 24 |
                                      (static_cast<std::uint32_t>(mantissa) & 0xffffff)));
    }
    const std::string floats = decoded(bytesOf(numbers), 8, "EXPONENTIAL");
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        float value = 0.0f;
        std::memcpy(&value, floats.data() + 4 * i, 4);
        const std::int32_t mantissa =
            static_cast<std::int32_t>(static_cast<std::uint32_t>(numbers[i]) << 8) >> 8;
        EXPECT_EQ(value, std::ldexp(static_cast<float>(mantissa), numbers[i] >> 24));
    }

    // x and y of the octahedron with z as the value of one; directions as bytes.
    std::vector<std::int8_t> folded;
    for (std::size_t i = 0; i < kCount; ++i) {
        for (int k = 0; k < 2; ++k)
            folded.push_back(static_cast<std::int8_t>(random() % 255 - 127));
        folded.push_back(127);
        folded.push_back(static_cast<std::int8_t>(i));
    }
    const std::string directions = decoded(bytesOf(folded), 4, "OCTAHEDRAL");
    for (std::size_t i = 0; i < kCount; ++i) {
        glm::vec3 n(folded[4 * i] / 127.0f, folded[4 * i + 1] / 127.0f, 0.0f);
        n.z = 1.0f - std::abs(n.x) - std::abs(n.y);
        const float t = std::max(-n.z, 0.0f);
        n.x += n.x >= 0.0f ? -t : t;
        n.y += n.y >= 0.0f ? -t : t;
        n = glm::normalize(n);
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(static_cast<std::int8_t>(directions[4 * i + k]), 127.0f * n[k], 0.6f);
        }
        EXPECT_EQ(directions[4 * i + 3], folded[4 * i + 3]) << "the fourth is kept";
    }

    // Three components of a unit quaternion, the largest one left out; the fourth number has its
    // index in its lowest two bits.
    std::vector<std::int16_t> turned;
    std::vector<glm::vec4> turns;
    std::normal_distribution<float> normal;
    for (std::size_t i = 0; i < kCount; ++i) {
        glm::vec4 q(normal(random), normal(random), normal(random), normal(random));
        q = glm::normalize(q);
        int largest = 0;
        for (int k = 1; k < 4; ++k) {
            if (std::abs(q[k]) > std::abs(q[largest])) largest = k;
        }
        if (q[largest] < 0.0f) q = -q;
        turns.push_back(q);
        for (int k = 1; k < 4; ++k) {
            const float share = q[(largest + k) % 4] * std::sqrt(2.0f);
            turned.push_back(static_cast<std::int16_t>(std::lround(share * 32767.0f)));
        }
        turned.push_back(static_cast<std::int16_t>(32764 | largest));
    }
    const std::string quaternions = decoded(bytesOf(turned), 8, "QUATERNION");
    for (std::size_t i = 0; i < kCount; ++i) {
        for (int k = 0; k < 4; ++k) {
            std::int16_t value = 0;
            std::memcpy(&value, quaternions.data() + 8 * i + 2 * static_cast<unsigned>(k), 2);
            EXPECT_NEAR(value / 32767.0f, turns[i][k], 2e-4f) << i << ' ' << k;
        }
    }
}

// INDICES: any order, in 2 bytes too.
TEST_F(Compression, SequencesOfIndicesAreExact) {
    std::mt19937 random(11);
    std::vector<std::uint32_t> indices;
    for (int i = 0; i < 1001; ++i) indices.push_back(random() % 60000);
    std::string encoded(meshopt_encodeIndexSequenceBound(indices.size(), 60000), '\0');
    encoded.resize(meshopt_encodeIndexSequence(reinterpret_cast<unsigned char*>(encoded.data()),
                                               encoded.size(), indices.data(), indices.size()));
    for (const std::size_t stride : {2u, 4u}) {
        const std::string bytes = decodedMeshopt(
            {.count = indices.size(), .stride = stride, .mode = "INDICES", .filter = ""},
            {reinterpret_cast<const unsigned char*>(encoded.data()), encoded.size()}, "view");
        ASSERT_EQ(bytes.size(), stride * indices.size());
        for (std::size_t i = 0; i < indices.size(); ++i) {
            std::uint32_t value = 0;
            std::memcpy(&value, bytes.data() + stride * i, stride);
            ASSERT_EQ(value, indices[i]) << i;
        }
    }
}

TEST_F(Compression, WrongDescriptionsAreRejectedWithTheirReason) {
    const Sheet sheet = sheetOf(5);
    struct Row {
        const char* key;
        json value;
        const char* words;
    };
    const auto meshoptWith = [&](const Row& row) {
        return meshoptGlb(sheet, [&](json& document) {
            document["bufferViews"][0]["extensions"]["EXT_meshopt_compression"][row.key] =
                row.value;
        });
    };
    for (const Row& row :
         {Row{"mode", "SOMETHING", "known are ATTRIBUTES, TRIANGLES and INDICES"},
          Row{"byteStride", 260, "byteStride of 4 to 256"}, Row{"byteStride", 6, "multiple of 4"},
          Row{"mode", "TRIANGLES", "byteStride of 2 or 4"},
          Row{"filter", "QUATERNION", "QUATERNION of 8"},
          Row{"filter", "UNKNOWN", "filter that does not fit"},
          Row{"count", 37, "does not have the byteLength"}, Row{"count", 4'000'000, "too short"},
          Row{"count", 4'000'000'000, "too many elements"},
          Row{"byteLength", 1'000'000, "exceeds its buffer"}, Row{"byteLength", 0, "damaged"}}) {
        EXPECT_THAT(refusalOf(meshoptWith(row)).what(), HasSubstr(row.words)) << row.key;
    }
    const auto dracoWith = [&](const std::function<void(json&)>& change) {
        return refusalOf(dracoGlb(sheet, change));
    };
    EXPECT_THAT(dracoWith([](json& d) { d["accessors"][0]["count"] = 1'000'000; }).what(),
                HasSubstr("does not have as many elements"));
    const ImportError bomb = dracoWith([](json& d) { d["accessors"][0]["count"] = 3; });
    EXPECT_EQ(bomb.reason(), ImportError::Reason::limit) << "before it is decoded";
    EXPECT_THAT(bomb.what(), HasSubstr("declares 50 triangles and 36 vertices"));
    EXPECT_THAT(dracoWith([](json& d) { d["accessors"][3]["componentType"] = 5126; }).what(),
                HasSubstr("component type cannot hold"));
    EXPECT_THAT(dracoWith([](json& d) {
                    d["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]
                     ["attributes"]["POSITION"] = 77;
                }).what(),
                HasSubstr("no attribute of id 77"));
}

// Truncated at and changed at random places: a scene or a reason.
TEST_F(Compression, DamagedStreamsGiveASceneOrAReason) {
    const Sheet sheet = sheetOf(9);
    const std::string meshopt = meshoptGlb(sheet), draco = dracoGlb(sheet);
    std::mt19937 random(3);
    int read = 0, refused = 0;
    for (int seed = 0; seed < 600; ++seed) {
        std::string file = seed % 2 ? meshopt : draco;
        std::uint32_t jsonBytes = 0;
        std::memcpy(&jsonBytes, file.data() + 12, 4);
        const std::size_t stream = 20 + jsonBytes + 8;
        for (int k = 0; k < 1 + seed % 4; ++k) {
            file[stream + random() % (file.size() - stream)] = static_cast<char>(random());
        }
        if (seed % 5 == 0) {  // zeros to the end
            const std::size_t from = stream + random() % (file.size() - stream);
            std::fill(file.begin() + static_cast<std::ptrdiff_t>(from), file.end(), '\0');
        }
        try {
            sceneOf(file);
            ++read;
        } catch (const ImportError& error) {
            EXPECT_NE(std::string(error.what()), "");
            ++refused;
        } catch (const std::bad_alloc&) {  // "not enough memory", by the child process
            ++refused;
        }
    }
    std::printf("%d read, %d refused\n", read, refused);
    EXPECT_GT(refused, 100);
}

// The target is twice the time of the plain form.
TEST_F(Compression, PrintsTheTimeOfLoading) {
    const Sheet sheet = sheetOf(400);
    const auto time = [&](const std::string& glb) {
        const auto began = std::chrono::steady_clock::now();
        sceneOf(glb);
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - began)
            .count();
    };
    const std::string plain = plainGlb(sheet), meshopt = meshoptGlb(sheet), draco = dracoGlb(sheet);
    time(plain);
    const double base = time(plain), byMeshopt = time(meshopt), byDraco = time(draco);
    std::printf(
        "320,000 triangles: plain %.0f ms (%.1f MB), meshopt %.0f ms (%.1f MB), ratio %.2f; "
        "Draco %.0f ms (%.1f MB), ratio %.2f\n",
        base, 1e-6 * static_cast<double>(plain.size()), byMeshopt,
        1e-6 * static_cast<double>(meshopt.size()), byMeshopt / base, byDraco,
        1e-6 * static_cast<double>(draco.size()), byDraco / base);
}

}  // namespace
}  // namespace clerestory::test
