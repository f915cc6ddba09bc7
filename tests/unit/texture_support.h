// Shared by the tests of compressed textures: decoding from memory, and a file with one texture.
#pragma once

#include "scene/import/textures/image_decoder.h"
#include "tests/unit/compression_support.h"

#include <atomic>
#include <functional>
#include <string>

namespace clerestory::test {

inline TextureImage decoded(const std::string& file, std::uint64_t maxPixels = 1'000'000) {
    std::atomic<std::uint64_t> left{maxPixels};
    return decodedImage({reinterpret_cast<const unsigned char*>(file.data()), file.size()},
                        maxPixels, left);
}

inline std::string errorOfImage(const std::string& file, std::uint64_t maxPixels = 1'000'000) {
    try {
        decoded(file, maxPixels);
    } catch (const ImportError& error) {
        return std::string(nameOf(error.reason())) + ": " + error.what();
    }
    return "was decoded";
}

// A triangle with one texture. `place` puts the images into the document.
inline std::string texturedGlb(
    const std::function<void(GlbBuilder&, nlohmann::json& texture)>& place) {
    GlbBuilder builder;
    const Surface surface = wavySurface(2);
    builder.primitive()["attributes"]["POSITION"] = builder.accessor(
        builder.view(bytesOf(surface.positions)), kGltfFloat, surface.positions.size(), "VEC3");
    builder.primitive()["indices"] = builder.accessor(
        builder.view(bytesOf(surface.indices)), kGltfUnsignedInt, surface.indices.size(), "SCALAR");
    builder.primitive()["material"] = 0;
    builder.json()["materials"] =
        nlohmann::json::parse(R"([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}])");
    builder.json()["textures"] = nlohmann::json::array({nlohmann::json::object()});
    builder.json()["images"] = nlohmann::json::array();
    place(builder, builder.json()["textures"][0]);
    return builder.glb();
}

inline int image(GlbBuilder& builder, const std::string& bytes) {
    nlohmann::json& images = builder.json()["images"];
    images.push_back({{"bufferView", builder.view(bytes)}});
    return static_cast<int>(images.size()) - 1;
}

}  // namespace clerestory::test
