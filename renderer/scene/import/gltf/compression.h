// Decoders of compressed vertices and indices: EXT_meshopt_compression (by libmeshoptimizer) and
// KHR_draco_mesh_compression (by libdraco). Everything they return has the size that the file
// declares, or they throw ImportError (malformed, limit).
//
// Formats: the extensions' specifications in the Khronos glTF registry.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace clerestory {

// How EXT_meshopt_compression describes the content of a buffer view.
struct MeshoptLayout {
    std::uint64_t count = 0;   // of elements
    std::uint64_t stride = 0;  // bytes of one element
    std::string_view mode;     // "ATTRIBUTES", "TRIANGLES" or "INDICES"
    std::string_view filter;   // "NONE", "OCTAHEDRAL", "QUATERNION" or "EXPONENTIAL"; "": NONE
};

// The view's content, count * stride bytes. `name` is that of the view, for messages.
std::string decodedMeshopt(const MeshoptLayout& layout, std::span<const unsigned char> encoded,
                           const std::string& name);

struct DracoLimits {
    std::uint64_t triangles = 0, vertices = 0;
};

// One primitive.
//
//     const DracoMesh mesh(document.bufferView(view), {1000, accessorCount}, name);
//     bytes = mesh.attribute(id, kFloat, 3);
class DracoMesh {
public:
    // What the stream declares is compared with the limits before anything is allocated for it.
    DracoMesh(std::span<const unsigned char> encoded, const DracoLimits& limits, std::string name);
    ~DracoMesh();

    std::size_t vertices() const;
    std::size_t triangles() const;

    // Three for each triangle, tightly packed. componentType: as in an accessor (5121, 5123, 5125).
    std::string indices(std::uint64_t componentType) const;
    // Of all vertices, tightly packed. id: the attribute's unique id in the stream.
    std::string attribute(std::uint32_t id, std::uint64_t componentType,
                          std::size_t components) const;

private:
    struct Decoded;
    std::unique_ptr<const Decoded> decoded_;
    std::string name_;
};

}  // namespace clerestory
