#include "scene/import/gltf/compression.h"

#include "scene/import/base/imported_scene.h"
#include "scene/import/base/types.h"

#include <draco/compression/decode.h>
#include <draco/compression/point_cloud/point_cloud_decoder.h>
#include <draco/core/decoder_buffer.h>
#include <draco/core/varint_decoding.h>
#include <draco/mesh/mesh.h>
#include <draco/metadata/metadata_decoder.h>

#include <cstring>
#include <limits>
#include <utility>

namespace clerestory {
namespace {

[[noreturn]] void wrongMesh(const std::string& name, const std::string& what) {
    throw ImportError(ImportError::Reason::malformed, "compressed " + name + " " + what);
}

template <class T>
void append(std::string& bytes, const T* values, std::size_t count) {
    bytes.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

template <class T>
std::string packedIndices(const draco::Mesh& mesh) {
    std::string bytes;
    bytes.reserve(std::size_t{3} * mesh.num_faces() * sizeof(T));
    for (draco::FaceIndex face(0); face < mesh.num_faces(); ++face) {
        for (const draco::PointIndex& corner : mesh.face(face)) {
            if (corner.value() > std::numeric_limits<T>::max()) return {};
            const auto index = static_cast<T>(corner.value());
            append(bytes, &index, 1);
        }
    }
    return bytes;
}

// Empty if a value does not fit, or lies outside of the attribute's memory, which the library does
// not check.
template <class T>
std::string packedValues(const draco::PointAttribute& attribute, std::size_t vertices,
                         std::size_t components) {
    if (!attribute.is_mapping_identity() && attribute.indices_map_size() < vertices) return {};
    const std::uint64_t size = attribute.buffer() ? attribute.buffer()->data_size() : 0;
    const auto stride = static_cast<std::uint64_t>(attribute.byte_stride());
    std::string bytes;
    bytes.reserve(vertices * components * sizeof(T));
    T values[4] = {};
    for (draco::PointIndex vertex(0); vertex < static_cast<std::uint32_t>(vertices); ++vertex) {
        const draco::AttributeValueIndex at = attribute.mapped_index(vertex);
        const auto position = static_cast<std::uint64_t>(attribute.GetBytePos(at));
        if (size < stride || position > size - stride ||
            !attribute.ConvertValue<T>(at, static_cast<std::int8_t>(components), values)) {
            return {};
        }
        append(bytes, values, components);
    }
    return bytes;
}

draco::DecoderBuffer bufferOf(std::span<const unsigned char> encoded) {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(encoded.data()), encoded.size());
    return buffer;
}

// The numbers at the start of the connectivity: Draco bitstream specification 2.2, sections
// "Connectivity Decoder", "Sequential Decoder" and "EdgeBreaker Decoder".
void checkDeclared(std::span<const unsigned char> encoded, const DracoLimits& limits,
                   const std::string& name) {
    draco::DecoderBuffer buffer = bufferOf(encoded);
    draco::DracoHeader header{};
    if (!draco::PointCloudDecoder::DecodeHeader(&buffer, &header).ok() ||
        header.encoder_type != draco::TRIANGULAR_MESH) {
        wrongMesh(name, "is damaged or no Draco mesh");
    }
    if (header.version_major != 2 || header.version_minor != 2) {
        throw ImportError(ImportError::Reason::unsupported,
                          "compressed " + name + " has version " +
                              std::to_string(header.version_major) + "." +
                              std::to_string(header.version_minor) + " of Draco; supported is 2.2");
    }
    buffer.set_bitstream_version(draco::kDracoMeshBitstreamVersion);
    draco::GeometryMetadata ignored;
    const bool hasMetadata = (header.flags & METADATA_FLAG_MASK) != 0;
    bool sound = !hasMetadata || draco::MetadataDecoder().DecodeGeometryMetadata(&buffer, &ignored);
    std::uint32_t triangles = 0, vertices = 0;
    if (header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING) {
        std::uint8_t traversal = 0;
        sound = sound && buffer.Decode(&traversal) && draco::DecodeVarint(&vertices, &buffer) &&
                draco::DecodeVarint(&triangles, &buffer);
    } else {
        sound = sound && draco::DecodeVarint(&triangles, &buffer) &&
                draco::DecodeVarint(&vertices, &buffer);
    }
    if (!sound) wrongMesh(name, "is damaged or no Draco mesh");
    if (triangles > limits.triangles || vertices > limits.vertices) {
        throw ImportError(ImportError::Reason::limit,
                          "compressed " + name + " declares " + std::to_string(triangles) +
                              " triangles and " + std::to_string(vertices) +
                              " vertices; its accessors and the limit of triangles allow " +
                              std::to_string(limits.triangles) + " and " +
                              std::to_string(limits.vertices));
    }
}

}  // namespace

struct DracoMesh::Decoded {
    std::unique_ptr<draco::Mesh> mesh;
};

DracoMesh::DracoMesh(std::span<const unsigned char> encoded, const DracoLimits& limits,
                     std::string name)
    : name_(std::move(name)) {
    checkDeclared(encoded, limits, name_);
    draco::DecoderBuffer buffer = bufferOf(encoded);
    draco::Decoder decoder;
    auto result = decoder.DecodeMeshFromBuffer(&buffer);
    if (!result.ok()) wrongMesh(name_, "is damaged or no Draco mesh");
    decoded_ = std::make_unique<const Decoded>(Decoded{std::move(result).value()});
}

DracoMesh::~DracoMesh() = default;

std::size_t DracoMesh::vertices() const {
    return decoded_->mesh->num_points();
}

std::size_t DracoMesh::triangles() const {
    return decoded_->mesh->num_faces();
}

std::string DracoMesh::indices(std::uint64_t componentType) const {
    const draco::Mesh& mesh = *decoded_->mesh;
    std::string bytes = componentType == 5121   ? packedIndices<std::uint8_t>(mesh)
                        : componentType == 5123 ? packedIndices<std::uint16_t>(mesh)
                        : componentType == 5125 ? packedIndices<std::uint32_t>(mesh)
                                                : std::string();
    if (bytes.empty() && mesh.num_faces() > 0) {
        wrongMesh(name_, "has indices that its accessor's component type cannot hold");
    }
    return bytes;
}

std::string DracoMesh::attribute(std::uint32_t id, std::uint64_t componentType,
                                 std::size_t components) const {
    const draco::PointAttribute* attribute = decoded_->mesh->GetAttributeByUniqueId(id);
    if (!attribute || components < 1 || components > 4) {
        wrongMesh(name_, "has no attribute of id " + std::to_string(id));
    }
    const std::size_t count = vertices();
    std::string bytes;
    switch (componentType) {
        case 5120:
            bytes = packedValues<std::int8_t>(*attribute, count, components);
            break;
        case 5121:
            bytes = packedValues<std::uint8_t>(*attribute, count, components);
            break;
        case 5122:
            bytes = packedValues<std::int16_t>(*attribute, count, components);
            break;
        case 5123:
            bytes = packedValues<std::uint16_t>(*attribute, count, components);
            break;
        case 5125:
            bytes = packedValues<std::uint32_t>(*attribute, count, components);
            break;
        case 5126:
            bytes = packedValues<float>(*attribute, count, components);
            break;
        default:
            break;
    }
    if (bytes.empty() && count > 0) {
        wrongMesh(name_, "has an attribute that its accessor's component type cannot hold");
    }
    return bytes;
}

}  // namespace clerestory
