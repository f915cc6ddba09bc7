#include "scene/import/gltf/document.h"

#include "scene/import/base/clean_text.h"
#include "scene/import/base/imported_scene.h"
#include "scene/import/gltf/meshopt.h"

#include <algorithm>
#include <cstring>
#include <set>

namespace clerestory {
namespace {

// An accessor without a buffer view has no bytes in the file, so its length needs a limit.
constexpr std::uint64_t kMaxElements = 1u << 23;

std::uint32_t littleEndian(const std::string& bytes, std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 4; i-- > 0;) {
        value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
    }
    return value;
}

int base64Digit(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    if (c == '+' || c == '-') return 62;
    if (c == '/' || c == '_') return 63;
    return -1;
}

std::string base64Decoded(std::string_view text) {
    std::string bytes;
    bytes.reserve(text.size() * 3 / 4);
    std::uint32_t bits = 0;
    int bitCount = 0;
    for (const char c : text) {
        const int digit = base64Digit(c);
        if (digit < 0) {
            if (c == '=') break;
            malformed("a data URI is not base64");
        }
        bits = bits << 6 | static_cast<std::uint32_t>(digit);
        bitCount += 6;
        if (bitCount >= 8) {
            bitCount -= 8;
            bytes += static_cast<char>(bits >> bitCount & 0xff);
        }
    }
    return bytes;
}

template <class T>
T loaded(const unsigned char* from) {
    T value;
    std::memcpy(&value, from, sizeof value);
    return value;
}

double component(const unsigned char* from, std::uint64_t type) {
    switch (type) {
        case kGltfByte:
            return loaded<std::int8_t>(from);
        case kGltfUnsignedByte:
            return loaded<std::uint8_t>(from);
        case kGltfShort:
            return loaded<std::int16_t>(from);
        case kGltfUnsignedShort:
            return loaded<std::uint16_t>(from);
        case kGltfUnsignedInt:
            return loaded<std::uint32_t>(from);
        default:
            return static_cast<double>(loaded<float>(from));
    }
}

std::size_t componentBytes(std::uint64_t type) {
    switch (type) {
        case kGltfByte:
        case kGltfUnsignedByte:
            return 1;
        case kGltfShort:
        case kGltfUnsignedShort:
            return 2;
        case kGltfUnsignedInt:
        case kGltfFloat:
            return 4;
        default:
            malformed("an accessor has an unknown component type");
    }
}

// The integer that represents 1; 0 if integers are not normalised. glTF 2.0, 3.6.2.2.
double normalizedOne(std::uint64_t type, bool normalized) {
    if (!normalized) return 0.0;
    switch (type) {
        case kGltfByte:
            return 127.0;
        case kGltfUnsignedByte:
            return 255.0;
        case kGltfShort:
            return 32767.0;
        case kGltfUnsignedShort:
            return 65535.0;
        default:
            return 0.0;
    }
}

}  // namespace

// The memory layout of an accessor.
struct GltfDocument::Layout {
    std::uint64_t count = 0;
    std::uint64_t type = 0;
    std::size_t components = 0;
    std::size_t rows = 0;         // components of one column
    std::size_t columnBytes = 0;  // matrix columns are aligned to four bytes
    std::size_t elementBytes = 0;
    double one = 0.0;
};

GltfDocument::GltfDocument(std::string file, const SceneFolder& folder, const ImportLimits& limits)
    : folder_(folder), limits_(limits) {
    if (!file.starts_with("glTF")) {
        if (file.find('{') == std::string::npos)
            malformed("the file is neither JSON nor a .glb file");
        json_ = parsedFile(file);
        return;
    }
    constexpr std::uint32_t kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
    if (file.size() < 20 || littleEndian(file, 4) != 2 || littleEndian(file, 16) != kJsonChunk) {
        malformed("the .glb header is not that of glTF 2.0");
    }
    if (littleEndian(file, 8) > file.size()) {
        malformed("the .glb file has " + std::to_string(file.size()) + " of " +
                  std::to_string(littleEndian(file, 8)) + " bytes");
    }
    const std::size_t jsonBytes = littleEndian(file, 12);
    if (jsonBytes > file.size() - 20) {
        malformed("the .glb file ends within its JSON");
    }
    json_ = parsedFile(std::string_view(file).substr(20, jsonBytes));
    const std::size_t next = 20 + (jsonBytes + 3) / 4 * 4;
    if (next + 8 <= file.size() && littleEndian(file, next + 4) == kBinaryChunk) {
        const std::size_t bytes = littleEndian(file, next);
        if (bytes > file.size() - next - 8) {
            malformed("the .glb file ends within its binary chunk");
        }
        file.erase(0, next + 8);
        file.resize(bytes);
        binaryChunk_ = std::move(file);
        hasBinaryChunk_ = true;
    }
}

const Json& GltfDocument::item(const char* list, Index i) const {
    return element(array(json_, list), i, list);
}

bool isDataUri(const std::string& uri) {
    return uri.starts_with("data:");
}

ByteSpan GltfDocument::dataUri(const std::string& uri) {
    const std::size_t comma = uri.find(',');
    if (!isDataUri(uri) || comma == std::string::npos ||
        !std::string_view(uri).substr(0, comma).ends_with(";base64")) {
        malformed("a data URI is not base64");
    }
    const auto [entry, isNew] = dataUris_.try_emplace(uri);
    if (isNew) {
        entry->second = base64Decoded(std::string_view(uri).substr(comma + 1));
    }
    return {reinterpret_cast<const unsigned char*>(entry->second.data()), entry->second.size()};
}

void GltfDocument::refuseMissingFiles() const {
    constexpr std::size_t kNamed = 6;
    std::set<std::string> missing;
    for (const char* list : {"buffers", "images"}) {
        const Json none = Json::array();
        for (const Json& part : json_.contains(list) ? json_.at(list) : none) {
            const std::string uri = text(part, "uri");
            if (!uri.empty() && !isDataUri(uri) && !folder_.has(percentDecoded(uri))) {
                missing.insert(cleanText(uri));
            }
        }
    }
    std::string names;
    std::size_t count = 0;
    for (const std::string& name : missing) {
        if (count++ < kNamed) names += (names.empty() ? "'" : ", '") + name + "'";
    }
    if (count > kNamed) names += " and " + std::to_string(count - kNamed) + " more";
    malformed((count > 1 ? "the files " + names + " are missing; they belong"
                         : "the file " + names + " is missing; it belongs") +
              std::string(" next to the scene, or into an archive (") +
              extensionsText(FormatUse::archive) + ") with the scene");
}

const std::string& GltfDocument::buffer(Index i) {
    const auto known = buffers_.find(i);
    if (known != buffers_.end()) {
        return known->second;
    }
    const Json& description = item("buffers", i);
    std::string bytes;
    if (!description.contains("uri")) {
        if (i != 0 || !hasBinaryChunk_) {
            malformed("buffer " + std::to_string(i) + " has no bytes");
        }
        bytes = std::move(binaryChunk_);
    } else if (const std::string uri = text(description, "uri"); isDataUri(uri)) {
        const ByteSpan data = dataUri(uri);
        bytes.assign(data.begin(), data.end());
    } else {
        try {
            bytes = folder_.read(percentDecoded(uri));
        } catch (const ImportError& error) {
            // The scene file exists, but a file that it refers to does not.
            if (error.reason() == ImportError::Reason::notFound) refuseMissingFiles();
            throw;
        }
    }
    if (wholeNumber(description, "byteLength", 0) > bytes.size()) {
        malformed("buffer " + std::to_string(i) + " is shorter than its byteLength");
    }
    return buffers_[i] = std::move(bytes);
}

ByteSpan GltfDocument::bufferPart(const Json& part, const std::string& name) {
    const std::string& bytes = buffer(indexAt(part, "buffer"));
    const std::uint64_t offset = wholeNumber(part, "byteOffset", 0);
    const std::uint64_t length = wholeNumber(part, "byteLength", 0);
    if (offset > bytes.size() || length > bytes.size() - offset) {
        malformed(name + " exceeds its buffer");
    }
    return {reinterpret_cast<const unsigned char*>(bytes.data()) + offset, length};
}

ByteSpan GltfDocument::bufferView(Index i) {
    const Json& view = item("bufferViews", i);
    const std::string name = "buffer view " + std::to_string(i);
    const Json* compressed = extension(view, "EXT_meshopt_compression");
    if (!compressed) return bufferPart(view, name);
    auto known = decompressedViews_.find(i);
    if (known == decompressedViews_.end()) {
        const MeshoptLayout layout = meshoptLayout(view, *compressed, name, limits_.fileBytes);
        const ByteSpan stream = bufferPart(*compressed, name);
        countDecompressed(layout.bytes());
        known = decompressedViews_.emplace(i, decodedMeshopt(stream, layout, name)).first;
    }
    return {reinterpret_cast<const unsigned char*>(known->second.data()), known->second.size()};
}

// As for files: all of them together may have four times as many bytes as one.
void GltfDocument::countDecompressed(std::uint64_t bytes) {
    decompressedBytes_ += bytes;
    if (decompressedBytes_ > 4 * limits_.fileBytes) {
        throw ImportError(ImportError::Reason::limit, "the compressed data expands to more than " +
                                                          std::to_string(4 * limits_.fileBytes) +
                                                          " bytes");
    }
}

GltfDocument::Layout GltfDocument::layout(const Json& accessor) const {
    static const std::map<std::string, std::pair<std::size_t, std::size_t>> kShapes{
        {"SCALAR", {1, 1}}, {"VEC2", {2, 1}}, {"VEC3", {3, 1}}, {"VEC4", {4, 1}},
        {"MAT2", {2, 2}},   {"MAT3", {3, 3}}, {"MAT4", {4, 4}}};
    const auto shape = kShapes.find(text(accessor, "type"));
    if (shape == kShapes.end()) {
        malformed("an accessor has an unknown type");
    }
    const auto [rows, columns] = shape->second;
    Layout layout;
    layout.count = wholeNumber(accessor, "count", 0);
    if (layout.count > kMaxElements) {
        throw ImportError(ImportError::Reason::limit, "an accessor has too many elements");
    }
    layout.type = wholeNumber(accessor, "componentType", 0);
    layout.rows = rows;
    layout.components = rows * columns;
    const std::size_t column = rows * componentBytes(layout.type);
    layout.columnBytes = columns > 1 ? (column + 3) / 4 * 4 : column;
    layout.elementBytes = layout.columnBytes * columns;
    layout.one = normalizedOne(layout.type, flag(accessor, "normalized", false));
    return layout;
}

AccessorShape GltfDocument::shape(Index accessor) const {
    const Layout at = layout(item("accessors", accessor));
    return {at.count, at.type, at.components, at.elementBytes};
}

bool GltfDocument::hasBufferView(Index accessor) const {
    return item("accessors", accessor).contains("bufferView");
}

bool GltfDocument::requiresExtension(const char* name) const {
    const Json& required = array(json_, "extensionsRequired");
    return std::find(required.begin(), required.end(), Json(name)) != required.end();
}

void GltfDocument::setContent(Index accessor, std::uint64_t source, std::string bytes) {
    contents_[accessor] = {source, std::move(bytes)};
}

bool GltfDocument::hasContent(Index accessor, std::uint64_t source) const {
    const auto found = contents_.find(accessor);
    return found != contents_.end() && found->second.source == source;
}

// Copies all elements to `out`, then the sparse ones.
template <class Out, class Convert>
void GltfDocument::read(Index index_, std::vector<Out>& out, const Convert& convert) {
    const Json& accessor = item("accessors", index_);
    const Layout at = layout(accessor);
    const std::size_t size = componentBytes(at.type);
    out.assign(at.count * at.components, Out{});
    const auto copyElement = [&](const unsigned char* from, std::uint64_t to) {
        for (std::size_t c = 0; c < at.components; ++c) {
            const std::size_t offset = c / at.rows * at.columnBytes + c % at.rows * size;
            out[to * at.components + c] = convert(component(from + offset, at.type), at.one);
        }
    };
    const auto outside = [&] {
        malformed("accessor " + std::to_string(index_) + " exceeds its buffer view");
    };
    if (const auto content = contents_.find(index_); content != contents_.end()) {
        if (content->second.bytes.size() != at.count * at.elementBytes) outside();
        const auto* bytes = reinterpret_cast<const unsigned char*>(content->second.bytes.data());
        for (std::uint64_t i = 0; i < at.count; ++i) copyElement(bytes + i * at.elementBytes, i);
    } else if (const Index viewIndex = indexAt(accessor, "bufferView");
               viewIndex != kNone && at.count > 0) {
        const ByteSpan bytes = bufferView(viewIndex);
        const std::uint64_t offset = wholeNumber(accessor, "byteOffset", 0);
        std::uint64_t stride = wholeNumber(item("bufferViews", viewIndex), "byteStride", 0);
        stride = stride ? stride : at.elementBytes;
        if (stride > 65536 || offset > bytes.size() ||
            (at.count - 1) * stride + at.elementBytes > bytes.size() - offset) {
            outside();
        }
        for (std::uint64_t i = 0; i < at.count; ++i) {
            copyElement(bytes.data() + offset + i * stride, i);
        }
    }
    if (accessor.contains("sparse")) {
        const Json& sparse = object(accessor, "sparse");
        const Json& indices = object(sparse, "indices");
        const Json& values = object(sparse, "values");
        const std::uint64_t replaced = wholeNumber(sparse, "count", 0);
        const std::uint64_t indexType = wholeNumber(indices, "componentType", 0);
        const std::size_t indexBytes = componentBytes(indexType);
        const ByteSpan indexSpan = bufferView(indexAt(indices, "bufferView"));
        const ByteSpan valueSpan = bufferView(indexAt(values, "bufferView"));
        const std::uint64_t indexOffset = wholeNumber(indices, "byteOffset", 0);
        const std::uint64_t valueOffset = wholeNumber(values, "byteOffset", 0);
        if (replaced > at.count || indexOffset > indexSpan.size() ||
            replaced * indexBytes > indexSpan.size() - indexOffset ||
            valueOffset > valueSpan.size() ||
            replaced * at.elementBytes > valueSpan.size() - valueOffset) {
            outside();
        }
        for (std::uint64_t i = 0; i < replaced; ++i) {
            const double index =
                component(indexSpan.data() + indexOffset + i * indexBytes, indexType);
            if (!(index >= 0.0 && index < static_cast<double>(at.count))) {
                outside();
            }
            copyElement(valueSpan.data() + valueOffset + i * at.elementBytes,
                        static_cast<std::uint64_t>(index));
        }
    }
}

Numbers GltfDocument::floats(Index accessor) {
    Numbers numbers;
    numbers.components = layout(item("accessors", accessor)).components;
    read(accessor, numbers.values, [](double value, double one) {
        return static_cast<float>(one > 0.0 ? std::max(value / one, -1.0) : value);
    });
    return numbers;
}

std::vector<std::uint32_t> GltfDocument::integers(Index accessor) {
    std::vector<std::uint32_t> result;
    read(accessor, result, [](double value, double) {
        // Other values become an index that is out of range.
        return value >= 0.0 && value < 4294967295.0 ? static_cast<std::uint32_t>(value) : kNone;
    });
    return result;
}

}  // namespace clerestory
