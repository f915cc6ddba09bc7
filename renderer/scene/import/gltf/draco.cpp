#include "scene/import/gltf/draco.h"

#include "scene/import/base/types.h"

#include <draco/compression/decode.h>
#include <draco/compression/point_cloud/point_cloud_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/metadata_decoder.h>

#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

namespace clerestory {
namespace {

using Reason = ImportError::Reason;

struct DracoSize {
    std::uint64_t faces = 0;
    std::uint64_t vertices = 0;  // at least one point each
};

// An accessor of the primitive, and where the decoded mesh has its content.
struct DracoPart {
    static constexpr std::uint32_t kIndices = 0xffffffff;  // in place of an attribute's id
    Index accessor = kNone;
    std::uint32_t id = kIndices;
    AccessorShape shape;
    // Identifies the content among all primitives.
    std::uint64_t source(Index view) const { return std::uint64_t{view} << 32 | id; }
};

class DracoStream {
public:
    DracoStream(ByteSpan bytes, Index view)
        : bytes_(bytes), name_("the Draco mesh in buffer view " + std::to_string(view)) {}

    const std::string& name() const { return name_; }

    // The numbers at the start of the connectivity: Draco bitstream specification 2.2, sections
    // "Connectivity Decoder", "Sequential Decoder" and "EdgeBreaker Decoder".
    DracoSize declaredSize() const {
        draco::DecoderBuffer buffer = start();
        draco::DracoHeader header{};
        if (!draco::PointCloudDecoder::DecodeHeader(&buffer, &header).ok()) damaged();
        if (header.encoder_type != draco::TRIANGULAR_MESH) {
            malformed(name_ + " is not a mesh but a point cloud");
        }
        if (header.version_major != 2 || header.version_minor != 2) {
            throw ImportError(Reason::unsupported,
                              name_ + " has version " + std::to_string(header.version_major) + "." +
                                  std::to_string(header.version_minor) + "; supported is 2.2");
        }
        buffer.set_bitstream_version(draco::kDracoMeshBitstreamVersion);
        if ((header.flags & METADATA_FLAG_MASK) != 0) {
            draco::GeometryMetadata ignored;
            if (!draco::MetadataDecoder().DecodeGeometryMetadata(&buffer, &ignored)) damaged();
        }
        std::uint8_t traversal = 0;
        std::uint32_t faces = 0, vertices = 0;
        const bool edgeBreaker = header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING;
        const bool read =
            edgeBreaker
                ? buffer.Decode(&traversal) && draco::DecodeVarint(&vertices, &buffer) &&
                      draco::DecodeVarint(&faces, &buffer)
                : draco::DecodeVarint(&faces, &buffer) && draco::DecodeVarint(&vertices, &buffer);
        if (!read) damaged();
        return {faces, vertices};
    }

    std::unique_ptr<draco::Mesh> decoded() const {
        draco::DecoderBuffer buffer = start();
        try {
            auto mesh = draco::Decoder().DecodeMeshFromBuffer(&buffer);
            if (!mesh.ok() || !mesh.value()) damaged();
            return std::move(mesh).value();
        } catch (const std::bad_alloc&) {
            throw ImportError(Reason::memory, "not enough memory for " + name_);
        } catch (const std::length_error&) {
            throw ImportError(Reason::memory, "not enough memory for " + name_);
        }
    }

    [[noreturn]] void damaged() const { malformed(name_ + " is damaged"); }

private:
    draco::DecoderBuffer start() const {
        draco::DecoderBuffer buffer;
        buffer.Init(reinterpret_cast<const char*>(bytes_.data()), bytes_.size());
        return buffer;
    }

    ByteSpan bytes_;
    std::string name_;
};

// Copies the attribute's value of each point. Returns false if a value is outside the range of T.
template <class T>
bool copyValues(const draco::PointAttribute& attribute, draco::DataType sameType,
                std::size_t components, std::size_t points, std::string& bytes) {
    bytes.resize(points * components * sizeof(T));
    const bool explicitMap = !attribute.is_mapping_identity();
    if (explicitMap && attribute.indices_map_size() < points) return false;
    const std::uint64_t size = attribute.buffer() ? attribute.buffer()->data_size() : 0;
    const auto stride = static_cast<std::uint64_t>(attribute.byte_stride());
    char* to = bytes.data();
    for (std::uint32_t p = 0; p < points; ++p, to += components * sizeof(T)) {
        const draco::AttributeValueIndex value = attribute.mapped_index(draco::PointIndex(p));
        const auto at = static_cast<std::uint64_t>(attribute.GetBytePos(value));
        if (size < stride || at > size - stride) return false;
        if (attribute.data_type() == sameType) {
            std::memcpy(to, attribute.GetAddress(value), components * sizeof(T));
            continue;
        }
        T converted[4];
        if (!attribute.ConvertValue(value, static_cast<std::int8_t>(components), converted)) {
            return false;
        }
        std::memcpy(to, converted, components * sizeof(T));
    }
    return true;
}

bool copyAttribute(const draco::PointAttribute& attribute, const AccessorShape& shape,
                   std::string& bytes) {
    const auto copy = [&](auto type, draco::DataType sameType) {
        return copyValues<decltype(type)>(attribute, sameType, shape.components, shape.count,
                                          bytes);
    };
    switch (shape.componentType) {
        case kGltfByte:
            return copy(std::int8_t{}, draco::DT_INT8);
        case kGltfUnsignedByte:
            return copy(std::uint8_t{}, draco::DT_UINT8);
        case kGltfShort:
            return copy(std::int16_t{}, draco::DT_INT16);
        case kGltfUnsignedShort:
            return copy(std::uint16_t{}, draco::DT_UINT16);
        case kGltfUnsignedInt:
            return copy(std::uint32_t{}, draco::DT_UINT32);
        default:
            return copy(float{}, draco::DT_FLOAT32);
    }
}

template <class T>
bool copyCorners(const draco::Mesh& mesh, std::string& bytes) {
    std::vector<T> corners;
    corners.reserve(std::size_t{3} * mesh.num_faces());
    for (std::uint32_t f = 0; f < mesh.num_faces(); ++f) {
        for (const draco::PointIndex& corner : mesh.face(draco::FaceIndex(f))) {
            if (corner.value() > std::numeric_limits<T>::max()) return false;
            corners.push_back(static_cast<T>(corner.value()));
        }
    }
    bytes.assign(reinterpret_cast<const char*>(corners.data()), corners.size() * sizeof(T));
    return true;
}

bool copyIndices(const draco::Mesh& mesh, std::uint64_t componentType, std::string& bytes) {
    switch (componentType) {
        case kGltfUnsignedByte:
            return copyCorners<std::uint8_t>(mesh, bytes);
        case kGltfUnsignedShort:
            return copyCorners<std::uint16_t>(mesh, bytes);
        case kGltfUnsignedInt:
            return copyCorners<std::uint32_t>(mesh, bytes);
        default:
            return false;
    }
}

// The primitive's indices first, then the attributes that the extension lists.
std::vector<DracoPart> partsOf(const GltfDocument& document, const Json& primitive,
                               const Json& draco, const std::string& name) {
    std::vector<DracoPart> parts;
    const auto add = [&](const Json& accessors, const char* key, std::uint32_t id) {
        const Index accessor = indexAt(accessors, key);
        if (accessor == kNone) {
            malformed(name + " belongs to a primitive without an accessor of its " +
                      (id == DracoPart::kIndices ? "indices" : "attributes"));
        }
        parts.push_back({accessor, id, document.shape(accessor)});
    };
    add(primitive, "indices", DracoPart::kIndices);
    const Json& attributes = object(draco, "attributes");
    for (const auto& each : attributes.items()) {
        add(object(primitive, "attributes"), each.key().c_str(),
            indexAt(attributes, each.key().c_str()));
    }
    return parts;
}

// What the decoder will allocate is known from the accessors, which must agree with the stream.
void checkSizes(const DracoStream& stream, const std::vector<DracoPart>& parts,
                std::uint64_t maxTriangles) {
    const DracoSize declared = stream.declaredSize();
    if (declared.faces > maxTriangles) {
        throw ImportError(Reason::limit, stream.name() + " has " + std::to_string(declared.faces) +
                                             " triangles; allowed are " +
                                             std::to_string(maxTriangles));
    }
    if (parts.front().shape.count != 3 * declared.faces) {
        malformed(stream.name() + " has " + std::to_string(declared.faces) +
                  " triangles, and the accessor of its indices has " +
                  std::to_string(parts.front().shape.count) + " elements");
    }
    for (std::size_t i = 1; i < parts.size(); ++i) {
        if (parts[i].shape.count != parts[1].shape.count) {
            malformed("the accessors of " + stream.name() + " have different counts");
        }
        if (parts[i].shape.count < declared.vertices) {
            malformed(stream.name() + " has " + std::to_string(declared.vertices) +
                      " vertices, and the accessors of its attributes have " +
                      std::to_string(parts[i].shape.count) + " elements");
        }
    }
}

std::string contentOf(const draco::Mesh& mesh, const DracoPart& part, const DracoStream& stream) {
    std::string bytes;
    if (part.id == DracoPart::kIndices) {
        if (!copyIndices(mesh, part.shape.componentType, bytes)) {
            malformed("the indices of " + stream.name() + " do not fit the type of their accessor");
        }
        return bytes;
    }
    const std::string name = "attribute " + std::to_string(part.id) + " of " + stream.name();
    const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(part.id);
    if (!attribute) malformed(name + " does not exist");
    if (part.shape.count != mesh.num_points() || part.shape.components > 4 ||
        attribute->num_components() != part.shape.components) {
        malformed(name + " has " + std::to_string(mesh.num_points()) + " elements of " +
                  std::to_string(attribute->num_components()) + " components; its accessor has " +
                  std::to_string(part.shape.count) + " of " +
                  std::to_string(part.shape.components));
    }
    if (!copyAttribute(*attribute, part.shape, bytes)) {
        malformed(name + " has values outside the range of its accessor's type");
    }
    return bytes;
}

}  // namespace

void decodeDraco(GltfDocument& document, const Json& primitive, std::uint64_t maxTriangles) {
    constexpr const char* kExtension = "KHR_draco_mesh_compression";
    const Json* draco = extension(primitive, kExtension);
    if (!draco) return;
    const Index view = indexAt(*draco, "bufferView");
    const DracoStream stream(document.bufferView(view), view);
    const std::vector<DracoPart> parts = partsOf(document, primitive, *draco, stream.name());
    bool complete = true, uncompressed = !document.requiresExtension(kExtension);
    for (const DracoPart& part : parts) {
        complete = complete && document.hasContent(part.accessor, part.source(view));
        uncompressed = uncompressed && document.hasBufferView(part.accessor);
    }
    if (complete || uncompressed) return;
    checkSizes(stream, parts, maxTriangles);
    for (const DracoPart& part : parts) document.countDecompressed(part.shape.bytes());
    const std::unique_ptr<draco::Mesh> mesh = stream.decoded();
    if (std::uint64_t{3} * mesh->num_faces() != parts.front().shape.count) stream.damaged();
    for (const DracoPart& part : parts) {
        document.setContent(part.accessor, part.source(view), contentOf(*mesh, part, stream));
    }
}

}  // namespace clerestory
