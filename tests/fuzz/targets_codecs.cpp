#include "scene/import/base/types.h"
#include "scene/import/gltf/document.h"
#include "scene/import/gltf/draco.h"
#include "scene/import/gltf/meshopt.h"
#include "scene/import/textures/avif_decoder.h"
#include "scene/import/textures/ktx2_texture.h"
#include "scene/import/textures/webp_decoder.h"
#include "tests/fuzz/targets.h"
#include "tests/support/scene_files.h"

#include <nlohmann/json.hpp>

#include <fstream>
#include <iterator>
#include <map>

namespace clerestory::test {
namespace {

// A huge image takes long, and finds nothing that a small one does not.
constexpr std::uint64_t kMaxPixels = 1 << 16;
constexpr std::uint64_t kMaxBytes = 1 << 20;

template <class Decode>
void decodes(const Decode& decode) {
    try {
        decode();
    } catch (const ImportError& error) {
        require(error.what()[0] != '\0', "a refusal has a reason");
    } catch (const std::bad_alloc&) {  // the importer's process has a limit
    }
}

template <class Decoder>
void fuzzImage(Bytes bytes, const Decoder& decoder) {
    decodes([&] {
        std::atomic<std::uint64_t> left{kMaxPixels};
        const TextureImage image = decoder(bytes, kMaxPixels, left);
        require(image.width > 0 && image.height > 0, "an image has pixels");
        require(image.texels.size() == std::size_t{4} * image.width * image.height,
                "and texels for each");
        require(left + std::uint64_t{image.width} * image.height == kMaxPixels,
                "which were counted");
    });
}

void fuzzWebp(Bytes bytes) {
    fuzzImage(bytes, decodedWebp);
}
void fuzzAvif(Bytes bytes) {
    fuzzImage(bytes, decodedAvif);
}
void fuzzKtx2(Bytes bytes) {
    fuzzImage(bytes, decodedKtx2);
}

// The first bytes are what the buffer view declares.
constexpr std::size_t kDeclared = 5;
void fuzzMeshopt(Bytes bytes) {
    if (bytes.size() < kDeclared) return;
    const MeshoptLayout layout{.mode = static_cast<MeshoptMode>(bytes[0] % 3),
                               .filter = static_cast<MeshoptFilter>(bytes[1] % 4),
                               .count = bytes[2] + 256u * bytes[3],
                               .stride = bytes[4]};
    static constexpr const char* kModes[] = {"ATTRIBUTES", "TRIANGLES", "INDICES"};
    static constexpr const char* kFilters[] = {"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"};
    decodes([&] {
        const nlohmann::json view{{"byteLength", layout.bytes()}, {"byteStride", layout.stride}};
        const nlohmann::json extension{{"buffer", 0},
                                       {"byteLength", bytes.size() - kDeclared},
                                       {"byteStride", layout.stride},
                                       {"count", layout.count},
                                       {"mode", kModes[bytes[0] % 3]},
                                       {"filter", kFilters[bytes[1] % 4]}};
        const MeshoptLayout checked = meshoptLayout(view, extension, "view", kMaxBytes);
        const std::string result = decodedMeshopt(bytes.subspan(kDeclared), checked, "view");
        require(result.size() == checked.bytes(), "a view has its bytes");
    });
}

std::string contentOf(const std::string& name) {
    std::ifstream file(std::string(CLERESTORY_SOURCE_DIR "/tests/scenes/compressed/") + name,
                       std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

struct Glb {
    nlohmann::json json;
    std::string binary;

    std::string view(std::size_t index) const {
        const auto& v = json["bufferViews"][index];
        return binary.substr(v.value("byteOffset", 0u), v.at("byteLength"));
    }
};
Glb glbAt(const std::string& name) {
    const std::string file = contentOf(name);
    constexpr std::size_t kHeader = 20, kChunkHeader = 8;
    const auto* length = reinterpret_cast<const std::uint32_t*>(file.data() + 12);
    return {nlohmann::json::parse(file.substr(kHeader, *length)),
            file.substr(kHeader + *length + kChunkHeader)};
}

// The bytes in place of the compressed part of a file whose accessors stay.
void fuzzDraco(Bytes bytes) {
    static const Glb kFile = glbAt("draco-edgebreaker.glb");
    nlohmann::json json = kFile.json;
    auto& primitive = json["meshes"][0]["primitives"][0];
    const std::size_t view = primitive["extensions"]["KHR_draco_mesh_compression"]["bufferView"];
    json["bufferViews"][view]["byteOffset"] = 0;
    json["bufferViews"][view]["byteLength"] = bytes.size();
    json["buffers"][0]["byteLength"] = bytes.size();
    const std::string binary(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    decodes([&] {
        const SceneFolder folder(std::map<std::string, std::string>{});
        GltfDocument document(glbOf(json.dump(), binary), folder, {.fileBytes = kMaxBytes});
        const auto& read = document.json()["meshes"][0]["primitives"][0];
        decodeDraco(document, read, 100'000);
        document.integers(read["indices"]);
        document.floats(read["attributes"]["POSITION"]);
    });
}

std::vector<std::string> imagesIn(const std::string& name) {
    const Glb file = glbAt(name);
    std::vector<std::string> images;
    for (const auto& image : file.json["images"]) {
        if (image.contains("bufferView")) images.push_back(file.view(image["bufferView"]));
    }
    return images;
}

void append(std::vector<std::string>& list, std::vector<std::string> more) {
    std::move(more.begin(), more.end(), std::back_inserter(list));
}

std::vector<std::string> meshoptSeeds() {
    std::vector<std::string> seeds;
    for (const char* name : {"meshopt.glb", "meshopt-indices.glb"}) {
        const Glb file = glbAt(name);
        for (const auto& view : file.json["bufferViews"]) {
            if (!view.contains("extensions")) continue;
            const auto& e = view["extensions"]["EXT_meshopt_compression"];
            const std::string mode = e.at("mode"), filter = e.value("filter", "NONE");
            const std::size_t count = e.at("count");
            std::string seed{static_cast<char>(mode == "ATTRIBUTES"  ? 0
                                               : mode == "TRIANGLES" ? 1
                                                                     : 2),
                             static_cast<char>(filter == "NONE"         ? 0
                                               : filter == "OCTAHEDRAL" ? 1
                                               : filter == "QUATERNION" ? 2
                                                                        : 3),
                             static_cast<char>(count % 256), static_cast<char>(count / 256),
                             static_cast<char>(e.at("byteStride").get<int>())};
            seeds.push_back(seed +
                            file.binary.substr(e.value("byteOffset", 0u), e.at("byteLength")));
        }
    }
    return seeds;
}

std::vector<std::string> dracoSeeds() {
    std::vector<std::string> seeds;
    for (const char* name :
         {"draco-edgebreaker.glb", "draco-sequential.glb", "draco-valence.glb"}) {
        const Glb file = glbAt(name);
        const auto& e = file.json["meshes"][0]["primitives"][0]["extensions"];
        seeds.push_back(file.view(e["KHR_draco_mesh_compression"]["bufferView"]));
    }
    return seeds;
}

}  // namespace

void (*codecTarget(const std::string& codec))(Bytes) {
    if (codec == "webp") return fuzzWebp;
    if (codec == "avif") return fuzzAvif;
    if (codec == "ktx2") return fuzzKtx2;
    if (codec == "meshopt") return fuzzMeshopt;
    require(codec == "draco", "CLERESTORY_CODEC is webp, avif, ktx2, meshopt or draco");
    return fuzzDraco;
}

std::vector<std::string> codecSeeds(const std::string& codec) {
    std::vector<std::string> seeds;
    if (codec == "webp") {
        append(seeds, imagesIn("webp.glb"));
        append(seeds, imagesIn("webp-lossless.glb"));
    }
    if (codec == "avif") append(seeds, imagesIn("avif.glb"));
    if (codec == "ktx2") {
        append(seeds, imagesIn("etc1s.glb"));
        append(seeds, imagesIn("uastc.glb"));
    }
    if (codec == "meshopt") append(seeds, meshoptSeeds());
    if (codec == "draco") append(seeds, dracoSeeds());
    require(!seeds.empty(), "a codec has seeds");
    return seeds;
}

}  // namespace clerestory::test
