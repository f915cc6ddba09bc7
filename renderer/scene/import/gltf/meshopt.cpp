#include "scene/import/gltf/meshopt.h"

#include <meshoptimizer.h>

#include <array>
#include <string_view>
#include <utility>

namespace clerestory {
namespace {

template <class Value, std::size_t N>
Value valueNamed(const std::string& text,
                 const std::array<std::pair<std::string_view, Value>, N>& values,
                 const std::string& name, const char* what) {
    for (const auto& [spelling, value] : values) {
        if (spelling == text) return value;
    }
    malformed(name + " has an unknown meshopt " + what);
}

constexpr std::array kModes{std::pair{std::string_view("ATTRIBUTES"), MeshoptMode::attributes},
                            std::pair{std::string_view("TRIANGLES"), MeshoptMode::triangles},
                            std::pair{std::string_view("INDICES"), MeshoptMode::indices}};
constexpr std::array kFilters{
    std::pair{std::string_view("NONE"), MeshoptFilter::none},
    std::pair{std::string_view("OCTAHEDRAL"), MeshoptFilter::octahedral},
    std::pair{std::string_view("QUATERNION"), MeshoptFilter::quaternion},
    std::pair{std::string_view("EXPONENTIAL"), MeshoptFilter::exponential}};

// The rules of the extension's specification; the library asserts them.
void checkStride(const MeshoptLayout& layout, const std::string& name) {
    const std::uint64_t stride = layout.stride;
    const auto require = [&](bool allowed, const char* rule) {
        if (!allowed) {
            malformed(name + " has a meshopt byteStride of " + std::to_string(stride) +
                      "; allowed is " + rule);
        }
    };
    if (layout.mode != MeshoptMode::attributes) {
        require(stride == 2 || stride == 4, "2 or 4 for indices");
        if (layout.filter != MeshoptFilter::none) malformed(name + " has a filter on indices");
        return;
    }
    require(stride > 0 && stride <= 256 && stride % 4 == 0, "a multiple of 4 up to 256");
    if (layout.filter == MeshoptFilter::octahedral) {
        require(stride == 4 || stride == 8, "4 or 8 with the filter OCTAHEDRAL");
    } else if (layout.filter == MeshoptFilter::quaternion) {
        require(stride == 8, "8 with the filter QUATERNION");
    }
}

bool decoded(void* to, ByteSpan stream, const MeshoptLayout& layout) {
    switch (layout.mode) {
        case MeshoptMode::triangles:
            return meshopt_decodeIndexBuffer(to, layout.count, layout.stride, stream.data(),
                                             stream.size()) == 0;
        case MeshoptMode::indices:
            return meshopt_decodeIndexSequence(to, layout.count, layout.stride, stream.data(),
                                               stream.size()) == 0;
        default:
            return meshopt_decodeVertexBuffer(to, layout.count, layout.stride, stream.data(),
                                              stream.size()) == 0;
    }
}

void applyFilter(void* to, const MeshoptLayout& layout) {
    switch (layout.filter) {
        case MeshoptFilter::octahedral:
            return meshopt_decodeFilterOct(to, layout.count, layout.stride);
        case MeshoptFilter::quaternion:
            return meshopt_decodeFilterQuat(to, layout.count, layout.stride);
        case MeshoptFilter::exponential:
            return meshopt_decodeFilterExp(to, layout.count, layout.stride);
        default:
            return;
    }
}

}  // namespace

MeshoptLayout meshoptLayout(const Json& view, const Json& extension, const std::string& name,
                            std::uint64_t maxBytes) {
    MeshoptLayout layout;
    layout.mode = valueNamed(text(extension, "mode"), kModes, name, "mode");
    if (extension.contains("filter")) {
        layout.filter = valueNamed(text(extension, "filter"), kFilters, name, "filter");
    }
    layout.count = wholeNumber(extension, "count", 0);
    layout.stride = wholeNumber(extension, "byteStride", 0);
    checkStride(layout, name);
    if (layout.count > maxBytes / layout.stride) {
        throw ImportError(ImportError::Reason::limit,
                          name + " expands to " + std::to_string(layout.count) + " elements of " +
                              std::to_string(layout.stride) + " bytes; allowed are " +
                              std::to_string(maxBytes) + " bytes");
    }
    if (layout.mode == MeshoptMode::triangles && layout.count % 3 != 0) {
        malformed(name + " has " + std::to_string(layout.count) +
                  " triangle indices, which is not a multiple of 3");
    }
    if (layout.bytes() != wholeNumber(view, "byteLength", 0) ||
        wholeNumber(view, "byteStride", layout.stride) != layout.stride) {
        malformed(name + " does not have the size of its decoded content, " +
                  std::to_string(layout.count) + " elements of " + std::to_string(layout.stride) +
                  " bytes");
    }
    return layout;
}

std::string decodedMeshopt(ByteSpan stream, const MeshoptLayout& layout, const std::string& name) {
    std::string bytes(layout.bytes(), '\0');
    if (!decoded(bytes.data(), stream, layout)) {
        malformed("the meshopt stream of " + name + " is damaged");
    }
    applyFilter(bytes.data(), layout);
    return bytes;
}

}  // namespace clerestory
