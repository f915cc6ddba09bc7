// S3: small scenes with one fault each, uploaded: repaired, so that the image equals that of the
// valid scene; drawn as far as possible; or rejected with a reason.
#include "tests/http/uploads_support.h"

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <ostream>

namespace clerestory::test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// A rough red square of one metre in the plane z = 0, with additions.
struct Square {
    std::vector<float> positions{-0.5f, -0.5f, 0, 0.5f, -0.5f, 0, 0.5f, 0.5f, 0, -0.5f, 0.5f, 0};
    std::vector<float> normals{0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    std::vector<float> uvs{0, 0, 1, 0, 1, 1, 0, 1};
    std::vector<std::uint16_t> indices{0, 1, 2, 0, 2, 3};

    // Another corner; returns its index.
    std::uint16_t add(float x, float y, float z) {
        positions.insert(positions.end(), {x, y, z});
        normals.insert(normals.end(), {0, 0, 1});
        uvs.insert(uvs.end(), {0, 0});
        return static_cast<std::uint16_t>(positions.size() / 3 - 1);
    }
    void triangle(std::uint16_t a, std::uint16_t b, std::uint16_t c) {
        indices.insert(indices.end(), {a, b, c});
    }
};

enum class Outcome { mended, drawn, refused };

struct FaultyScene {
    const char* name;
    Outcome outcome;
    std::function<void(Square&)> data = [](Square&) {};
    std::function<void(json&)> document = [](json&) {};
};
std::ostream& operator<<(std::ostream& out, const FaultyScene& odd) {
    return out << odd.name;
}

template <class T>
void addView(json& document, std::string& binary, const std::vector<T>& values, const char* type,
             int components, int componentType) {
    const std::size_t bytes = values.size() * sizeof(T);
    document["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", bytes}});
    document["accessors"].push_back(
        {{"bufferView", document["bufferViews"].size() - 1},
         {"componentType", componentType},
         {"type", type},
         {"count", values.size() / static_cast<std::size_t>(components)}});
    binary.append(reinterpret_cast<const char*>(values.data()), bytes);
    binary.resize((binary.size() + 3) / 4 * 4);
}

std::string fileOf(const FaultyScene& odd) {
    Square square;
    odd.data(square);
    json document = json::parse(R"({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2},
                                    "indices": 3, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness":
                          {"baseColorFactor": [0.8, 0.1, 0.1, 1], "metallicFactor": 0}}]})");
    std::string binary;
    addView(document, binary, square.positions, "VEC3", 3, 5126);
    document["accessors"][0]["min"] = {-0.5, -0.5, 0};
    document["accessors"][0]["max"] = {0.5, 0.5, 0};
    addView(document, binary, square.normals, "VEC3", 3, 5126);
    addView(document, binary, square.uvs, "VEC2", 2, 5126);
    addView(document, binary, square.indices, "SCALAR", 1, 5123);
    document["buffers"] = {{{"byteLength", binary.size()}}};
    odd.document(document);
    return glbOf(document.dump(), binary);
}

json& primitiveOf(json& document) {
    return document["meshes"][0]["primitives"][0];
}
auto put(const char* pointer, json value) {
    return [pointer, value](json& d) { d[json::json_pointer(pointer)] = value; };
}
auto withoutAttribute(const char* name) {
    return [name](json& d) { primitiveOf(d)["attributes"].erase(name); };
}
const auto kAsIs = [](Square&) {};
using enum Outcome;

const std::vector<FaultyScene> kOdd = {
    {"no normals", mended, kAsIs, withoutAttribute("NORMAL")},
    {"normals of length 0", mended, [](Square& s) { s.normals.assign(12, 0.0f); }},
    {"normals of NaN", mended, [](Square& s) { s.normals.assign(12, kNan); }},
    {"normals of a million", mended,
     [](Square& s) {
         for (float& n : s.normals) n *= 1e6f;
     }},
    {"no texture coordinates", mended, kAsIs, withoutAttribute("TEXCOORD_0")},
    {"texture coordinates of NaN", mended, [](Square& s) { s.uvs.assign(8, kNan); }},
    {"texture coordinates without end", mended, [](Square& s) { s.uvs.assign(8, kInfinity); }},
    {"a triangle with one corner twice", mended, [](Square& s) { s.triangle(0, 1, 1); }},
    {"a triangle without area", mended,
     [](Square& s) { s.triangle(0, s.add(0, 0, 0), s.add(0.25f, 0.25f, 0)); }},
    {"a triangle that is there twice", mended, [](Square& s) { s.triangle(0, 1, 2); }},
    {"an unused vertex of NaN", mended, [](Square& s) { s.add(kNan, 0, 0); }},
    {"a triangle with a corner of NaN", mended,
     [](Square& s) { s.triangle(0, 1, s.add(kNan, kNan, kNan)); }},
    {"a triangle with a corner without end", mended,
     [](Square& s) { s.triangle(0, 1, s.add(kInfinity, 0, 0)); }},
    {"a triangle of 1e30 metres", refused,
     [](Square& s) { s.triangle(0, s.add(1e30f, 0, -1), s.add(0, 1e30f, -1)); }},
    {"a triangle of 1e-30 metres", mended,
     [](Square& s) { s.triangle(0, s.add(-0.5f, -0.5f, 1e-30f), s.add(-0.5f, -0.5f, 2e-30f)); }},
    {"every corner in one place", refused, [](Square& s) { s.positions.assign(12, 0.0f); }},
    {"every corner of NaN", refused, [](Square& s) { s.positions.assign(12, kNan); }},
    {"an index that no corner has", mended, [](Square& s) { s.triangle(0, 1, 60000); }},
    {"indices that are no triangle's", mended, [](Square& s) { s.indices.push_back(1); }},
    {"no indices", drawn, kAsIs, [](json& d) { primitiveOf(d).erase("indices"); }},
    {"no positions", refused, kAsIs, withoutAttribute("POSITION")},
    {"no primitives", refused, kAsIs, put("/meshes/0/primitives", json::array())},
    {"no meshes", refused, kAsIs,
     [](json& d) {
         d.erase("meshes");
         d["nodes"][0].erase("mesh");
     }},
    {"no nodes", refused, kAsIs, put("/scenes/0/nodes", json::array())},
    {"no material", drawn, kAsIs, [](json& d) { primitiveOf(d).erase("material"); }},
    {"a material that is not there", refused, kAsIs, put("/meshes/0/primitives/0/material", 7)},
    {"a texture that is not there", refused, kAsIs,
     put("/materials/0/pbrMetallicRoughness/baseColorTexture", {{"index", 3}})},
    {"points", drawn, kAsIs, put("/meshes/0/primitives/0/mode", 0)},
    {"lines", drawn, kAsIs, put("/meshes/0/primitives/0/mode", 1)},
    {"a strip", drawn, kAsIs, put("/meshes/0/primitives/0/mode", 5)},
    {"a mode that glTF has not", refused, kAsIs, put("/meshes/0/primitives/0/mode", 99)},
    {"a node of scale 0 next to it", mended, kAsIs,
     [](json& d) {
         d["nodes"].push_back({{"mesh", 0}, {"scale", {0, 0, 0}}});
         d["scenes"][0]["nodes"] = {0, 1};
     }},
    {"a node that is flat", mended, kAsIs, put("/nodes/0/scale", {1, 1, 0})},
    {"a mirrored node", drawn, kAsIs, put("/nodes/0/scale", {-1, 1, 1})},
    {"a node 1e30 metres away", refused, kAsIs, put("/nodes/0/translation", {1e30, 0, 0})},
    {"a node 1e300 metres away", refused, kAsIs, put("/nodes/0/translation", {1e300, 0, 0})},
    {"a turn of length 0", mended, kAsIs, put("/nodes/0/rotation", {0, 0, 0, 0})},
    {"a turn of length 3", mended, kAsIs, put("/nodes/0/rotation", {0, 0, 0, 3})},
    {"a matrix of zeros", refused, kAsIs, put("/nodes/0/matrix", std::vector<double>(16, 0.0))},
    {"a node in itself", refused, kAsIs, put("/nodes/0/children", {0})},
    {"a node that is not there", refused, kAsIs, put("/scenes/0/nodes", {0, 9})},
    {"roughness of a thousand", drawn, kAsIs,
     put("/materials/0/pbrMetallicRoughness/roughnessFactor", 1000)},
    {"metal below 0", drawn, kAsIs, put("/materials/0/pbrMetallicRoughness/metallicFactor", -5)},
    {"light of 1e38", drawn, kAsIs,
     put("/materials/0",
         {{"emissiveFactor", {1, 1, 1}},
          {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 1e38}}}}}})},
    {"glass of index 0, transmission 9, attenuation 0", drawn, kAsIs,
     put("/materials/0/extensions",
         {{"KHR_materials_ior", {{"ior", 0}}},
          {"KHR_materials_transmission", {{"transmissionFactor", 9}}},
          {"KHR_materials_volume", {{"thicknessFactor", -1}, {"attenuationDistance", 0}}}})},
    {"a camera without an angle", drawn, kAsIs,
     [](json& d) {
         d["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0}, {"znear", 0}}}}};
         d["nodes"].push_back({{"camera", 0}});
         d["scenes"][0]["nodes"] = {0, 1};
     }},
    {"an accessor longer than its buffer", refused, kAsIs, put("/accessors/0/count", 5000)},
    {"a clip without moments", drawn, kAsIs,
     put("/animations", json::array({{{"channels", json::array()}, {"samplers", json::array()}}}))},
};

class MalformedScenes : public testing::TestWithParam<FaultyScene> {
protected:
    void SetUp() override {
        if (!server) server = std::make_unique<TestServer>(uploadConfig());
    }
    static void TearDownTestSuite() { server.reset(); }
    static inline std::unique_ptr<TestServer> server;
};

httplib::Result drawn32(httplib::Client& client, const std::string& id) {
    return postJson(client, "/v1/frames",
                    R"({"width": 48, "height": 32, "camera": {"position": [0, 0, 2], )"
                    R"("target": [0, 0, 0]}, "output": {"channel": "color", "format": "npy"}, )"
                    R"("scene": ")" +
                        id + "\"}");
}

void expectFinite(const std::string& npy) {
    std::uint16_t header = 0;
    ASSERT_GT(npy.size(), 10u);
    std::memcpy(&header, npy.data() + 8, sizeof header);
    std::vector<float> values((npy.size() - 10 - header) / sizeof(float));
    ASSERT_GE(values.size(), 48u * 32u * 3u);
    std::memcpy(values.data(), npy.data() + 10 + header, values.size() * sizeof(float));
    for (const float v : values) ASSERT_TRUE(std::isfinite(v) && v >= 0.0f) << v;
}

TEST_P(MalformedScenes, AreRepairedDrawnOrRejectedWithAReason) {
    auto client = server->client();
    const FaultyScene& odd = GetParam();
    const auto sent = send(client, fileOf(odd), "model/gltf-binary");
    ASSERT_TRUE(sent);
    if (odd.outcome == refused) {
        const json problem = problemOf(sent, 422);
        ASSERT_TRUE(problem.is_object()) << sent->status << sent->body;
        EXPECT_THAT(problem["type"].get<std::string>(), testing::EndsWith(":sceneFailed"));
        EXPECT_THAT(problem["reason"].get<std::string>(),
                    testing::AnyOf("malformed", "unsupported"));
        EXPECT_GT(problem["detail"].get<std::string>().size(), 20u) << sent->body;
        std::printf("%s: %s\n", odd.name, problem["detail"].get<std::string>().c_str());
        return;
    }
    ASSERT_EQ(sent->status, 201) << sent->body;
    std::printf("%s: %s\n", odd.name, json::parse(sent->body)["warnings"].dump().c_str());
    const auto frame = drawn32(client, idOf(sent));
    ASSERT_EQ(frame->status, 200) << frame->body;
    expectFinite(frame->body);
    if (odd.outcome == drawn) return;
    const std::string sound = fileOf({"sound", Outcome::drawn});
    const auto right = drawn32(client, idOf(send(client, sound, "model/gltf-binary")));
    EXPECT_TRUE(frame->body == right->body) << "the picture is not that of the sound square";
}

std::string nameOf(const testing::TestParamInfo<FaultyScene>& odd) {
    std::string name;
    for (const char c : std::string(odd.param.name)) name += std::isalnum(c) ? c : '_';
    return name;
}
INSTANTIATE_TEST_SUITE_P(S3, MalformedScenes, testing::ValuesIn(kOdd), nameOf);

}  // namespace
}  // namespace clerestory::test
