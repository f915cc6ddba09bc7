// A .gltf or .glb file: its JSON and its accessors as numbers.
//
// glTF is not read through Assimp 5.2.5, which loses or changes emissive strength, specular, all
// but one skin of a mesh, camera angles, quantised attributes and interpolation.
#pragma once

#include "scene/import/base/json_fields.h"
#include "scene/import/base/scene_folder.h"

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace clerestory {

using ByteSpan = std::span<const unsigned char>;

struct Numbers {
    std::size_t components = 0;  // per element
    std::vector<float> values;

    std::size_t count() const { return components ? values.size() / components : 0; }
    const float* at(std::size_t i) const { return values.data() + i * components; }
};

class GltfDocument {
public:
    // The folder must outlive the document. Throws ImportError.
    GltfDocument(std::string file, const SceneFolder& folder);

    const Json& json() const { return json_; }
    const Json& item(const char* list, Index i) const;  // json[list][i]; throws ImportError

    struct Shape {
        std::uint64_t componentType = 0;  // 5120 to 5126
        std::size_t components = 0;       // per element
        std::uint64_t count = 0;          // of elements
    };
    Shape shape(Index accessor) const;

    // An accessor as floats (normalised integers decoded, sparse values applied) or as integers.
    Numbers floats(Index accessor);
    std::vector<std::uint32_t> integers(Index accessor);

    // Decompressed where the view is compressed.
    ByteSpan bufferView(Index view);
    // The accessor's elements are these bytes, tightly packed, and not those of its buffer view.
    // They must be as many as it declares.
    void setElements(Index accessor, std::string bytes);
    bool hasElements(Index accessor) const { return elements_.contains(accessor); }
    // The content of a base64 data URI; the document owns the bytes. Throws ImportError for others.
    ByteSpan dataUri(const std::string& uri);

private:
    struct Layout;
    Layout layout(const Json& accessor) const;
    const std::string& buffer(Index i);
    // The part of a buffer that a buffer view, or its compressed form, describes.
    ByteSpan part(const Json& view, const std::string& name);
    template <class Out, class Convert>
    void read(Index accessor, std::vector<Out>& out, const Convert& convert);

    const SceneFolder& folder_;
    Json json_;
    std::string binaryChunk_;
    bool hasBinaryChunk_ = false;
    std::map<Index, std::string> buffers_;
    std::map<std::string, std::string> dataUris_;
    std::map<Index, std::string> decompressedViews_;
    std::map<Index, std::string> elements_;  // by accessor
};

bool isDataUri(const std::string& uri);

}  // namespace clerestory
