#include "scene/import/formats.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace clerestory {

std::span<const FileFormat> fileFormats() {
    using enum FormatUse;
    static constexpr std::array kFormats{
        FileFormat{
            scene, "glTF 2.0", ".gltf .glb",
            "Meshes, materials, textures, lights, cameras, skins, morph targets, animations and "
            "extras; extensions as in the table of glTF extensions."},
        FileFormat{
            scene, "Wavefront OBJ with MTL", ".obj",
            "Meshes, materials and textures through Assimp; MTL illumination models 3 to 9 give "
            "mirrors and glass. Units are metres."},
        FileFormat{
            scene, "Autodesk FBX", ".fbx",
            "Meshes, materials, textures, lights, cameras, skins and animations through Assimp; "
            "no morph targets."},
        FileFormat{
            scene, "COLLADA", ".dae",
            "Meshes, materials, textures, lights, cameras, skins and animations through Assimp; "
            "no morph targets."},
        FileFormat{scene, "Stanford PLY", ".ply", "One mesh with vertex colours, through Assimp."},
        FileFormat{scene, "STL", ".stl", "One mesh without material, through Assimp."},
        FileFormat{scene, "3D Studio", ".3ds", "Meshes, materials and textures through Assimp."},
        FileFormat{archive, "ZIP", ".zip",
                   "One .glb, .gltf or .obj file with the files it refers to, unpacked in memory."},
        FileFormat{archive, "tar, plain or gzip", ".tar .tgz",
                   "One .glb, .gltf or .obj file with the files it refers to, unpacked in memory."},
        FileFormat{texture, "JPEG", ".jpg .jpeg", "8 bits a channel, grey, RGB and CMYK."},
        FileFormat{texture, "PNG", ".png",
                   "8 or 16 bits a channel, reduced to 8 bits; with alpha."},
        FileFormat{texture, "BMP, TGA and PSD", ".bmp .tga .psd", "8 bits a channel."},
        FileFormat{environment, "Radiance HDR", ".hdr",
                   "Equirectangular, or one of six cube faces."},
        FileFormat{environment, "OpenEXR", ".exr",
                   "Equirectangular, or one of six cube faces; one part with channels R, G and B, "
                   "uncompressed or with RLE, ZIP or PIZ compression."},
        FileFormat{
            environment, "KTX cube map", ".ktx .ktx2",
            "Three or four channels of 8 or 16 bits, half or single floats, E5B9G9R9, "
            "B10G11R11, A2B10G10R10; S3TC, BPTC, ETC1 and ETC2 blocks. No supercompression."},
        FileFormat{environment, "folder of six faces", "px nx py ny pz nz",
                   "Square images of one size, each .hdr, .exr, .png or .jpg."},
        FileFormat{
            sidecar, "Clerestory sidecar", ".clerestory.json",
            "Material overrides, probes and the default environment of the scene file with the "
            "same stem."},
    };
    return kFormats;
}

std::string_view nameOf(FormatUse use) {
    constexpr std::array<std::string_view, 5> kNames{"scene", "archive", "texture", "environment",
                                                     "sidecar"};
    return kNames[static_cast<std::size_t>(use)];
}

const std::vector<std::string>& importableExtensions() {
    static const std::vector<std::string> kExtensions = [] {
        std::vector<std::string> list;
        for (const FileFormat& format : fileFormats()) {
            if (format.use != FormatUse::scene && format.use != FormatUse::archive) continue;
            std::string_view rest = format.extensions;
            while (!rest.empty()) {
                const std::size_t end = std::min(rest.find(' '), rest.size());
                list.emplace_back(rest.substr(1, end - 1));
                rest.remove_prefix(std::min(end + 1, rest.size()));
            }
        }
        return list;
    }();
    return kExtensions;
}

}  // namespace clerestory
