// Builds .glb files part by part, for tests of the glTF reader: a document with one mesh whose
// buffer views and accessors the test chooses, and a curved surface to put into it.
#pragma once

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace clerestory::test {

// Component types of glTF.
inline constexpr int kGltfByte = 5120, kGltfUnsignedByte = 5121, kGltfShort = 5122,
                     kGltfUnsignedShort = 5123, kGltfUnsignedInt = 5125, kGltfFloat = 5126;

// A wavy square with (side + 1)^2 vertices. Positions and texture coordinates are multiples of
// 1/4096 below 2 in absolute value: they have few bits, so that lossless encodings are exact.
struct Surface {
    std::vector<glm::vec3> positions, normals;
    std::vector<glm::vec2> texCoords;
    std::vector<std::uint32_t> indices;
};
Surface wavySurface(unsigned side);

template <class T>
std::string bytesOf(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}
std::string bytesOfIndices(const std::vector<std::uint32_t>& indices, int componentType);

class GlbBuilder {
public:
    // A node, and a mesh with one primitive without attributes.
    GlbBuilder();

    // Appends the bytes to buffer 0, aligned to 4, and returns their offset.
    std::size_t append(const std::string& bytes);
    // Appends a buffer view of these bytes and returns its index. stride 0: none is written.
    int view(const std::string& bytes, int stride = 0);
    // Appends an accessor and returns its index. view -1: none.
    int accessor(int view, int componentType, std::size_t count, const char* type,
                 bool normalized = false);

    nlohmann::json& json() { return json_; }
    nlohmann::json& primitive() { return json_["meshes"][0]["primitives"][0]; }

    // The file. Sets the length of buffer 0.
    std::string glb() const;

private:
    nlohmann::json json_;
    std::string binary_;
};

// A file with the surface, without compression.
std::string plainGlb(const Surface& surface, int indexType = kGltfUnsignedInt);

}  // namespace clerestory::test
