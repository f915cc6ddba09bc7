// A .gltf or .glb file: its JSON and its accessors as numbers.
//
// glTF is not read through Assimp 5.2.5, which loses or changes emissive strength, specular, all
// but one skin of a mesh, camera angles, quantised attributes and interpolation.
#pragma once

#include "scene/import/base/json_fields.h"
#include "scene/import/base/scene_folder.h"
#include "scene/import/base/types.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace clerestory {

struct Numbers {
    std::size_t components = 0;  // per element
    std::vector<float> values;

    std::size_t count() const { return components ? values.size() / components : 0; }
    const float* at(std::size_t i) const { return values.data() + i * components; }
};

// Component types of accessors.
inline constexpr std::uint64_t kGltfByte = 5120, kGltfUnsignedByte = 5121, kGltfShort = 5122,
                               kGltfUnsignedShort = 5123, kGltfUnsignedInt = 5125,
                               kGltfFloat = 5126;

struct AccessorShape {
    std::uint64_t count = 0;
    std::uint64_t componentType = 0;  // one of the constants above
    std::size_t components = 0;       // per element
    std::size_t elementBytes = 0;
    std::uint64_t bytes() const { return count * elementBytes; }
};

class GltfDocument {
public:
    // The folder must outlive the document. Throws ImportError.
    GltfDocument(std::string file, const SceneFolder& folder, const ImportLimits& limits);

    const Json& json() const { return json_; }
    const Json& item(const char* list, Index i) const;  // json[list][i]; throws ImportError

    // An accessor as floats (normalised integers decoded, sparse values applied) or as integers.
    Numbers floats(Index accessor);
    std::vector<std::uint32_t> integers(Index accessor);

    AccessorShape shape(Index accessor) const;
    bool hasBufferView(Index accessor) const;
    bool requiresExtension(const char* name) const;

    // Content of an accessor that lies in no buffer view, tightly packed. It replaces that of the
    // accessor's buffer view. source: identifies it; hasContent() compares it.
    void setContent(Index accessor, std::uint64_t source, std::string bytes);
    bool hasContent(Index accessor, std::uint64_t source) const;

    // Adds to the size of all decompressed data. Throws ImportError above the limit.
    void countDecompressed(std::uint64_t bytes);

    // Decompressed if it is compressed.
    ByteSpan bufferView(Index view);
    // The content of a base64 data URI; the document owns the bytes. Throws ImportError for others.
    ByteSpan dataUri(const std::string& uri);

private:
    struct Layout;
    Layout layout(const Json& accessor) const;
    const std::string& buffer(Index i);
    // Throws an ImportError that names the files of buffers and images that are not in the folder.
    [[noreturn]] void refuseMissingFiles() const;
    // The part of a buffer that an object with buffer, byteOffset and byteLength refers to.
    ByteSpan bufferPart(const Json& part, const std::string& name);
    template <class Out, class Convert>
    void read(Index accessor, std::vector<Out>& out, const Convert& convert);

    const SceneFolder& folder_;
    ImportLimits limits_;
    Json json_;
    std::string binaryChunk_;
    bool hasBinaryChunk_ = false;
    std::map<Index, std::string> buffers_;
    std::map<Index, std::string> decompressedViews_;
    struct Content {
        std::uint64_t source = 0;
        std::string bytes;
    };
    std::map<Index, Content> contents_;  // by accessor
    std::uint64_t decompressedBytes_ = 0;
    std::map<std::string, std::string> dataUris_;
};

bool isDataUri(const std::string& uri);

}  // namespace clerestory
