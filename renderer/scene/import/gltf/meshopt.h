// EXT_meshopt_compression: compressed buffer views, decoded by libmeshoptimizer after checks of
// their sizes.
//
// Does not: read buffers, or decode streams of format version 1 (KHR_meshopt_compression).
#pragma once

#include "scene/import/base/json_fields.h"
#include "scene/import/base/types.h"

#include <cstdint>
#include <string>

namespace clerestory {

enum class MeshoptMode : std::uint8_t { attributes, triangles, indices };
enum class MeshoptFilter : std::uint8_t { none, octahedral, quaternion, exponential };

// The decoded form of a compressed buffer view.
struct MeshoptLayout {
    MeshoptMode mode = MeshoptMode::attributes;
    MeshoptFilter filter = MeshoptFilter::none;
    std::uint64_t count = 0;   // elements
    std::uint64_t stride = 0;  // bytes of each
    std::uint64_t bytes() const { return count * stride; }
};

// Reads and checks the extension of a buffer view. `name` is for messages: "buffer view 3". Throws
// ImportError for an unknown mode or filter, a stride that the mode or the filter does not allow,
// more than maxBytes, and sizes that contradict those of the view.
MeshoptLayout meshoptLayout(const Json& view, const Json& extension, const std::string& name,
                            std::uint64_t maxBytes);

// Decodes the stream into layout.bytes() bytes. Indices are not checked against a vertex count.
// Throws ImportError if the stream is damaged.
std::string decodedMeshopt(ByteSpan stream, const MeshoptLayout& layout, const std::string& name);

}  // namespace clerestory
