#include "tests/support/glb_builder.h"

#include "tests/support/scene_files.h"

#include <cmath>

namespace clerestory::test {

Surface wavySurface(unsigned side) {
    Surface surface;
    const auto rounded = [](float value) { return std::round(value * 4096.0f) / 4096.0f; };
    for (unsigned y = 0; y <= side; ++y) {
        for (unsigned x = 0; x <= side; ++x) {
            const float u = static_cast<float>(x) / static_cast<float>(side);
            const float v = static_cast<float>(y) / static_cast<float>(side);
            const float height = 0.1f * std::sin(9.0f * u) * std::cos(7.0f * v);
            surface.positions.emplace_back(rounded(u), rounded(v), rounded(height));
            const glm::vec3 normal(-0.9f * std::cos(9.0f * u) * std::cos(7.0f * v),
                                   0.7f * std::sin(9.0f * u) * std::sin(7.0f * v), 1.0f);
            surface.normals.push_back(glm::normalize(normal));
            surface.texCoords.emplace_back(rounded(u), rounded(1.0f - v));
        }
    }
    for (unsigned y = 0; y < side; ++y) {
        for (unsigned x = 0; x < side; ++x) {
            const unsigned at = y * (side + 1) + x, above = at + side + 1;
            surface.indices.insert(surface.indices.end(),
                                   {at, at + 1, above, above, at + 1, above + 1});
        }
    }
    return surface;
}

std::string bytesOfIndices(const std::vector<std::uint32_t>& indices, int componentType) {
    if (componentType == kGltfUnsignedInt) return bytesOf(indices);
    return bytesOf(std::vector<std::uint16_t>(indices.begin(), indices.end()));
}

GlbBuilder::GlbBuilder()
    : json_(nlohmann::json::parse(R"({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {}}]}],
        "accessors": [], "bufferViews": [], "buffers": [{"byteLength": 0}]})")) {}

std::size_t GlbBuilder::append(const std::string& bytes) {
    binary_.resize((binary_.size() + 3) / 4 * 4, '\0');
    const std::size_t offset = binary_.size();
    binary_ += bytes;
    return offset;
}

int GlbBuilder::view(const std::string& bytes, int stride) {
    nlohmann::json view{{"buffer", 0}, {"byteOffset", append(bytes)}, {"byteLength", bytes.size()}};
    if (stride > 0) view["byteStride"] = stride;
    json_["bufferViews"].push_back(view);
    return static_cast<int>(json_["bufferViews"].size()) - 1;
}

int GlbBuilder::accessor(int view, int componentType, std::size_t count, const char* type,
                         bool normalized) {
    nlohmann::json accessor{{"componentType", componentType}, {"count", count}, {"type", type}};
    if (view >= 0) accessor["bufferView"] = view;
    if (normalized) accessor["normalized"] = true;
    json_["accessors"].push_back(accessor);
    return static_cast<int>(json_["accessors"].size()) - 1;
}

std::string GlbBuilder::glb() const {
    nlohmann::json json = json_;
    json["buffers"][0]["byteLength"] = binary_.size();
    return glbOf(json.dump(), binary_);
}

std::string plainGlb(const Surface& surface, int indexType) {
    GlbBuilder builder;
    const std::size_t count = surface.positions.size();
    const int positions = builder.view(bytesOf(surface.positions)),
              normals = builder.view(bytesOf(surface.normals)),
              texCoords = builder.view(bytesOf(surface.texCoords)),
              indices = builder.view(bytesOfIndices(surface.indices, indexType));
    builder.primitive()["attributes"] = {
        {"POSITION", builder.accessor(positions, kGltfFloat, count, "VEC3")},
        {"NORMAL", builder.accessor(normals, kGltfFloat, count, "VEC3")},
        {"TEXCOORD_0", builder.accessor(texCoords, kGltfFloat, count, "VEC2")}};
    builder.primitive()["indices"] =
        builder.accessor(indices, indexType, surface.indices.size(), "SCALAR");
    return builder.glb();
}

}  // namespace clerestory::test
