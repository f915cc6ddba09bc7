#include "scene/import/gltf/compression.h"

#include "scene/import/base/imported_scene.h"
#include "scene/import/base/types.h"

#include <meshoptimizer.h>

namespace clerestory {
namespace {

// The decoders expand an element to at most 64 times its bytes, so that a small file cannot declare
// much more than it holds; this keeps the product below within 64 bits.
constexpr std::uint64_t kMaxViewElements = 1u << 28;

[[noreturn]] void wrongView(const std::string& name, const std::string& what) {
    throw ImportError(ImportError::Reason::malformed, "compressed " + name + " " + what);
}

void checkLayout(const MeshoptLayout& layout, const std::string& name) {
    const auto [count, stride, mode, filter] = layout;
    if (count > kMaxViewElements) {
        throw ImportError(ImportError::Reason::limit,
                          "compressed " + name + " has too many elements");
    }
    if (mode == "ATTRIBUTES") {
        if (stride == 0 || stride > 256 || stride % 4 != 0) {
            wrongView(name, "needs a byteStride of 4 to 256, a multiple of 4");
        }
    } else if (mode == "TRIANGLES" || mode == "INDICES") {
        if (stride != 2 && stride != 4) wrongView(name, "needs a byteStride of 2 or 4");
        if (mode == "TRIANGLES" && count % 3 != 0) {
            wrongView(name, "needs a count that is a multiple of 3");
        }
    } else {
        wrongView(name, "has an unknown mode; known are ATTRIBUTES, TRIANGLES and INDICES");
    }
    if (filter.empty() || filter == "NONE") return;
    const bool fits = (filter == "OCTAHEDRAL" && (stride == 4 || stride == 8)) ||
                      (filter == "QUATERNION" && stride == 8) || filter == "EXPONENTIAL";
    if (mode != "ATTRIBUTES" || !fits) {
        wrongView(
            name,
            "has a filter that does not fit; OCTAHEDRAL needs a byteStride of 4 or 8, QUATERNION "
            "of 8, EXPONENTIAL a multiple of 4, each with mode ATTRIBUTES");
    }
}

}  // namespace

std::string decodedMeshopt(const MeshoptLayout& layout, std::span<const unsigned char> encoded,
                           const std::string& name) {
    checkLayout(layout, name);
    const auto [count, stride, mode, filter] = layout;
    if (count * stride / 64 > encoded.size() + 64) wrongView(name, "is too short for its count");
    std::string bytes(count * stride, '\0');
    if (count == 0) return bytes;
    const int error =
        mode == "ATTRIBUTES" ? meshopt_decodeVertexBuffer(bytes.data(), count, stride,
                                                          encoded.data(), encoded.size())
        : mode == "TRIANGLES"
            ? meshopt_decodeIndexBuffer(bytes.data(), count, stride, encoded.data(), encoded.size())
            : meshopt_decodeIndexSequence(bytes.data(), count, stride, encoded.data(),
                                          encoded.size());
    if (error != 0) wrongView(name, "is damaged or of a later version of the codec");
    if (filter == "OCTAHEDRAL") meshopt_decodeFilterOct(bytes.data(), count, stride);
    if (filter == "QUATERNION") meshopt_decodeFilterQuat(bytes.data(), count, stride);
    if (filter == "EXPONENTIAL") meshopt_decodeFilterExp(bytes.data(), count, stride);
    return bytes;
}

}  // namespace clerestory
