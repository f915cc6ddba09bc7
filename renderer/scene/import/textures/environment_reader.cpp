#include "scene/import/textures/environment_reader.h"

#include "scene/import/base/scene_folder.h"
#include "scene/import/base/types.h"
#include "scene/import/textures/image_decoder.h"
#include "scene/import/textures/texel_format.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string_view>

namespace clerestory {
namespace {

using Reason = ImportError::Reason;
using Bytes = std::span<const unsigned char>;

constexpr std::string_view kMagic1("\xABKTX 11\xBB\r\n\x1A\n", 12);
constexpr std::string_view kMagic2("\xABKTX 20\xBB\r\n\x1A\n", 12);
constexpr std::uint32_t kSameEndianness = 0x04030201;

bool opensWith(Bytes file, std::string_view magic) {
    return file.size() >= magic.size() && std::memcmp(file.data(), magic.data(), magic.size()) == 0;
}

[[noreturn]] void malformedKtx(const char* what) {
    throw ImportError(Reason::malformed, std::string("the KTX file ") + what);
}

// `count` bytes at `offset`. Throws ImportError if the file is shorter.
Bytes part(Bytes file, std::uint64_t offset, std::uint64_t count) {
    if (offset > file.size() || count > file.size() - offset) malformedKtx("is cut short");
    return file.subspan(static_cast<std::size_t>(offset), static_cast<std::size_t>(count));
}

template <class T>
T numberAt(Bytes file, std::uint64_t offset) {
    T value{};
    std::memcpy(&value, part(file, offset, sizeof value).data(), sizeof value);
    return value;
}

struct Faces {
    TexelFormat format;
    std::uint32_t size = 0;
    std::uint64_t faceBytes = 0;   // without padding between faces
    std::uint64_t faceStride = 0;  // from one face to the next
    std::uint64_t rowAlignment = 1;
    Bytes bytes;
    bool firstRowBelow = false;
};

void requireCube(std::uint32_t width, std::uint32_t height, std::uint32_t depth,
                 std::uint32_t layers, std::uint32_t faces) {
    if (faces != 6) {
        throw ImportError(Reason::unsupported, "the KTX file has no cube map: it has " +
                                                   std::to_string(faces) + " faces");
    }
    if (layers > 0) throw ImportError(Reason::unsupported, "arrays of cube maps are not supported");
    if (width == 0 || width != height || depth > 1) malformedKtx("has faces that are not square");
}

void requirePixels(std::uint32_t size, std::uint64_t maxPixels) {
    constexpr std::uint32_t kLargestEdge = 1u << 16;  // so that the product is a 64-bit number
    if (size > kLargestEdge || 6ull * size * size > maxPixels) {
        throw ImportError(Reason::limit, "the cube map of " + std::to_string(size) +
                                             " texels an edge exceeds the limit");
    }
}

// Key-value data: each pair is preceded by its length. KTXorientation has the direction of rows.
bool startsBelow(Bytes pairs) {
    while (pairs.size() >= 4) {
        const auto length = numberAt<std::uint32_t>(pairs, 0);
        const Bytes pair = part(pairs, 4, length);
        const std::string_view text(reinterpret_cast<const char*>(pair.data()), pair.size());
        constexpr std::string_view kKey("KTXorientation\0", 15);
        if (text.starts_with(kKey)) {
            const std::string_view value = text.substr(kKey.size());
            return value.find("T=u") != std::string_view::npos || value.starts_with("ru");
        }
        const std::uint64_t padded = (4ull + length + 3) / 4 * 4;
        if (padded >= pairs.size()) break;
        pairs = pairs.subspan(static_cast<std::size_t>(padded));
    }
    return false;
}

Faces facesOfKtx1(Bytes file, std::uint64_t maxPixels) {
    std::array<std::uint32_t, 13> header{};
    std::memcpy(header.data(), part(file, 12, sizeof header).data(), sizeof header);
    const auto [endianness, type, typeSize, layout, internal, baseInternal, width, height, depth,
                layers, faces, levels, pairBytes] = header;
    if (endianness != kSameEndianness) {
        throw ImportError(Reason::unsupported, "big-endian KTX files are not supported");
    }
    requireCube(width, height, depth, layers, faces);
    requirePixels(width, maxPixels);
    const Bytes pairs = part(file, 64, pairBytes);
    Faces result{.format = glFormat(internal, layout, type), .size = width, .rowAlignment = 4};
    result.firstRowBelow = startsBelow(pairs);
    result.faceBytes = result.format.bytesOf(width, result.rowAlignment);
    result.faceStride = (result.faceBytes + 3) / 4 * 4;
    const std::uint64_t first = 64ull + pairBytes;
    if (numberAt<std::uint32_t>(file, first) != result.faceBytes) {
        malformedKtx("has another size of a face than its format requires");
    }
    result.bytes = part(file, first + 4, 5 * result.faceStride + result.faceBytes);
    return result;
}

Faces facesOfKtx2(Bytes file, std::uint64_t maxPixels) {
    std::array<std::uint32_t, 13> header{};
    std::memcpy(header.data(), part(file, 12, sizeof header).data(), sizeof header);
    const auto [format, typeSize, width, height, depth, layers, faces, levels, compression,
                descriptor, descriptorBytes, pairsAt, pairBytes] = header;
    if (compression != 0) {
        constexpr std::array kNames{"", "BasisLZ", "Zstandard", "ZLIB"};
        throw ImportError(Reason::unsupported,
                          "KTX2 supercompression (" +
                              (compression < kNames.size() ? std::string(kNames[compression])
                                                           : std::to_string(compression)) +
                              ") is not supported");
    }
    requireCube(width, height, depth, layers, faces);
    requirePixels(width, maxPixels);
    Faces result{.format = vulkanFormat(format), .size = width};
    result.firstRowBelow = startsBelow(part(file, pairsAt, pairBytes));
    result.faceBytes = result.faceStride = result.format.bytesOf(width, 1);
    const auto offset = numberAt<std::uint64_t>(file, 80);
    const auto bytes = numberAt<std::uint64_t>(file, 88);
    if (bytes != 6 * result.faceBytes) {
        malformedKtx("has another size of its level than its format requires");
    }
    result.bytes = part(file, offset, bytes);
    return result;
}

Bytes bytesOf(const std::string& file) {
    return {reinterpret_cast<const unsigned char*>(file.data()), file.size()};
}

std::string environmentExtension(const std::filesystem::path& file) {
    std::string extension = file.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
    return extension;
}

// Finite, not negative, at most the largest half float.
glm::vec3 cleaned(const glm::vec3& texel) {
    constexpr float kLargestHalf = 65504.0f;
    glm::vec3 result(0.0f);
    for (int c = 0; c < 3; ++c) {
        result[c] = std::isnan(texel[c]) ? 0.0f : std::clamp(texel[c], 0.0f, kLargestHalf);
    }
    return result;
}

// Half the edge length; each texel is the mean of four.
RadianceCube halved(const RadianceCube& from) {
    RadianceCube to{.faceSize = from.faceSize / 2, .texels = {}};
    to.texels.reserve(from.texels.size() / 4);
    for (std::size_t y = 0; y < std::size_t{6} * from.faceSize; y += 2) {
        for (std::size_t x = 0; x < from.faceSize; x += 2) {
            const auto at = [&](std::size_t dx, std::size_t dy) {
                return from.texels[(y + dy) * from.faceSize + x + dx];
            };
            to.texels.push_back(0.25f * (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)));
        }
    }
    return to;
}

EnvironmentMap mapOf(RadianceCube cube) {
    for (glm::vec3& texel : cube.texels) texel = cleaned(texel);
    while (cube.faceSize > kMaxImportedFace) {
        if (cube.faceSize % 2 == 1) {
            throw ImportError(Reason::limit, "faces of " + std::to_string(cube.faceSize) +
                                                 " texels an edge cannot be halved");
        }
        cube = halved(cube);
    }
    EnvironmentMap map;
    map.faceSize = cube.faceSize;
    map.texels = std::move(cube.texels);
    return map;
}

// Two customs of naming the sides of +x, -x, +y, -y, +z and -z, OpenGL's order.
using FaceNames = std::array<const char*, 2>;
constexpr std::array<FaceNames, 6> kFaces{{{"px", "posx"},
                                           {"nx", "negx"},
                                           {"py", "posy"},
                                           {"ny", "negy"},
                                           {"pz", "posz"},
                                           {"nz", "negz"}}};

std::string faceFile(const SceneFolder& folder, const FaceNames& names) {
    for (const std::string name : names) {
        for (const char* extension : {".hdr", ".exr", ".png", ".jpg", ".jpeg"}) {
            if (folder.has(name + extension)) return name + extension;
        }
    }
    throw ImportError(Reason::notFound, std::string("the folder has no image named ") + names[0] +
                                            " or " + names[1] +
                                            " (.hdr, .exr, .png, .jpg or .jpeg)");
}

RadianceCube sixImages(const std::filesystem::path& path, const ImportLimits& limits) {
    const SceneFolder folder(path, limits.fileBytes);
    RadianceCube cube;
    for (const FaceNames& names : kFaces) {
        const std::string face = faceFile(folder, names);
        const RadianceImage image =
            decodedRadiance(bytesOf(folder.read(face)), limits.maxImagePixels / 6);
        if (cube.faceSize == 0) cube.faceSize = image.width;
        if (image.width != cube.faceSize || image.height != cube.faceSize) {
            throw ImportError(
                Reason::malformed,
                "the six images must be square and of equal size; " + face + " is not");
        }
        cube.texels.insert(cube.texels.end(), image.texels.begin(), image.texels.end());
    }
    return cube;
}

}  // namespace

bool isKtx(Bytes file) {
    return opensWith(file, kMagic1) || opensWith(file, kMagic2);
}

RadianceCube decodedKtxCube(Bytes file, std::uint64_t maxPixels) {
    if (!isKtx(file)) malformedKtx("has no KTX signature");
    const Faces faces =
        opensWith(file, kMagic1) ? facesOfKtx1(file, maxPixels) : facesOfKtx2(file, maxPixels);
    RadianceCube cube{.faceSize = faces.size, .texels = {}};
    const std::size_t faceTexels = std::size_t{faces.size} * faces.size;
    cube.texels.resize(6 * faceTexels);
    for (std::size_t face = 0; face < 6; ++face) {
        faces.format.decode(faces.bytes.subspan(face * static_cast<std::size_t>(faces.faceStride),
                                                static_cast<std::size_t>(faces.faceBytes)),
                            faces.size, faces.rowAlignment,
                            std::span(cube.texels).subspan(face * faceTexels, faceTexels));
        if (!faces.firstRowBelow) continue;
        const auto begin = cube.texels.begin() + static_cast<std::ptrdiff_t>(face * faceTexels);
        for (std::uint32_t y = 0; y < faces.size / 2; ++y) {
            std::swap_ranges(begin + std::ptrdiff_t{y} * faces.size,
                             begin + std::ptrdiff_t{y + 1} * faces.size,
                             begin + std::ptrdiff_t{faces.size - 1 - y} * faces.size);
        }
    }
    return cube;
}

EnvironmentMap readEnvironmentFile(const std::filesystem::path& fileOrFolder,
                                   const ImportLimits& limits) {
    std::error_code error;
    if (std::filesystem::is_directory(fileOrFolder, error)) {
        return mapOf(sixImages(fileOrFolder, limits));
    }
    const std::string extension = environmentExtension(fileOrFolder);
    constexpr std::array kExtensions{".hdr", ".exr", ".ktx", ".ktx2"};
    if (std::find(kExtensions.begin(), kExtensions.end(), extension) == kExtensions.end()) {
        throw ImportError(Reason::unsupported,
                          "an environment map is a .hdr, .exr, .ktx or .ktx2 file, or a folder of "
                          "six images");
    }
    const SceneFolder folder(fileOrFolder.parent_path(), limits.fileBytes);
    const std::string file = folder.read(fileOrFolder.filename().string());
    if (extension == ".ktx" || extension == ".ktx2") {
        return mapOf(decodedKtxCube(bytesOf(file), limits.maxImagePixels));
    }
    const RadianceImage image = decodedRadiance(bytesOf(file), limits.maxImagePixels);
    return environmentFromEquirectangular("", image.texels, image.width, image.height);
}

}  // namespace clerestory
