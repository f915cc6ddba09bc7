// KHR_draco_mesh_compression: compressed primitives, decoded by libdraco after checks of their
// sizes.
//
// Does not: decode point clouds, or bitstreams before version 2.2, which the extension requires.
#pragma once

#include "scene/import/base/json_fields.h"
#include "scene/import/gltf/document.h"

#include <cstdint>

namespace clerestory {

// Decodes a primitive that has the extension into the content of its accessors: the indices, and
// the attributes that the extension lists, in the component types that the accessors declare. Uses
// uncompressed accessors instead if the file has all of them and does not require the extension.
// Throws ImportError for more than maxTriangles, sizes that contradict those of the accessors,
// missing attributes, and damaged data.
void decodeDraco(GltfDocument& document, const Json& primitive, std::uint64_t maxTriangles);

}  // namespace clerestory
