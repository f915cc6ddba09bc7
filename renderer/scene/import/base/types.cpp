#include "scene/import/base/types.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <sstream>

namespace clerestory {

std::string_view nameOf(ImportError::Reason reason) {
    constexpr std::array<std::string_view, 7> kNames{
        "notFound", "unsupported", "malformed", "crashed", "timedOut", "memory", "limit"};
    return kNames[static_cast<std::size_t>(reason)];
}

std::string encoded(const ImportLimits& l) {
    std::ostringstream text;
    text << l.cpu.count() << ' ' << l.addressSpaceBytes << ' ' << l.fileBytes << ' '
         << l.maxTriangles << ' ' << l.maxNodes << ' ' << l.maxImagePixels << ' ' << l.maxFiles << ' '
         << l.maxDrawn;
    return text.str();
}

ImportLimits decodedLimits(const std::string& text) {
    ImportLimits limits;
    std::istringstream in(text);
    std::int64_t cpu = 0;
    if (in >> cpu) {
        limits.cpu = std::chrono::seconds(cpu);
    }
    for (std::uint64_t* value : {&limits.addressSpaceBytes, &limits.fileBytes, &limits.maxTriangles,
                                 &limits.maxNodes, &limits.maxImagePixels, &limits.maxFiles, &limits.maxDrawn}) {
        std::uint64_t read = 0;
        if (in >> read) {
            *value = read;
        }
    }
    return limits;
}

std::span<const FileFormat> fileFormats() {
    using enum FormatUse;
    static constexpr std::array kFormats{
        FileFormat{
            scene, "glTF 2.0", ".gltf .glb",
            "Meshes with triangles, lines and points, materials, textures, lights, cameras, skins, "
            "morph targets, animations and extras; extensions as in the table of glTF extensions."},
        FileFormat{
            scene, "Wavefront OBJ with MTL", ".obj",
            "Meshes with lines (`l`) and points (`p`), materials and textures through Assimp; MTL "
            "illumination models 3 to 9 give mirrors and glass. Without elements its vertices are "
            "points. Units are metres."},
        FileFormat{
            scene, "Autodesk FBX", ".fbx",
            "Meshes, materials, textures, lights, cameras, skins and animations through Assimp; "
            "no morph targets."},
        FileFormat{
            scene, "COLLADA", ".dae",
            "Meshes, materials, textures, lights, cameras, skins and animations through Assimp; "
            "no morph targets."},
        FileFormat{scene, "Stanford PLY", ".ply",
                   "One mesh with vertex colours, through Assimp; without normals, edges of more "
                   "than 45 degrees are sharp; without faces its vertices are "
                   "points."},
        FileFormat{scene, "STL", ".stl", "One mesh without material, through Assimp."},
        FileFormat{scene, "3D Studio", ".3ds", "Meshes, materials and textures through Assimp."},
        FileFormat{archive, "ZIP", ".zip",
                   "One scene file with the files that it refers to, unpacked in memory."},
        FileFormat{archive, "tar, plain or gzip", ".tar .tgz",
                   "One scene file with the files that it refers to, unpacked in memory."},
        FileFormat{texture, "JPEG", ".jpg .jpeg", "8 bits a channel, grey, RGB and CMYK."},
        FileFormat{texture, "PNG", ".png",
                   "8 or 16 bits a channel, reduced to 8 bits; with alpha."},
        FileFormat{texture, "WebP", ".webp", "Lossy and lossless, with alpha. No animations."},
        FileFormat{texture, "AVIF", ".avif",
                   "8, 10 or 12 bits a channel, reduced to 8 bits; with alpha. No sequences, no "
                   "cropping, rotation or mirroring."},
        FileFormat{texture, "KTX2", ".ktx2",
                   "UASTC, with or without Zstandard, and ETC1S with BasisLZ; two dimensions, the "
                   "largest level."},
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
        FileFormat{
            environment, "DDS cube map", ".dds",
            "With or without a DX10 header: three or four channels of 8 bits, four of 16 bits, "
            "half and single floats, R9G9B9E5, R11G11B10, R10G10B10A2; BC1 to BC3, BC6H, BC7. "
            "All six faces."},
        FileFormat{
            environment, "folder of six faces", "px nx py ny pz nz",
            "Square images of one size, each .hdr, .exr, .png or .jpg; also named posx, negx "
            "and so on."},
        FileFormat{
            sidecar, "Clerestory sidecar", ".clerestory.json",
            "Changes of materials and lights, probes and the default environment of the scene file "
            "with the same stem."},
    };
    return kFormats;
}

std::string_view nameOf(FormatUse use) {
    constexpr std::array<std::string_view, 5> kNames{"scene", "archive", "texture", "environment",
                                                     "sidecar"};
    return kNames[static_cast<std::size_t>(use)];
}

std::string lowerExtension(const std::filesystem::path& file) {
    std::string extension = file.extension().string();
    extension.erase(0, extension.empty() ? 0 : 1);
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
    return extension;
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

std::string extensionsText(FormatUse use) {
    std::string all;
    for (const FileFormat& format : fileFormats()) {
        if (format.use != use) continue;
        all += all.empty() ? "" : ", ";
        for (const char c : format.extensions) all += c == ' ' ? ", " : std::string(1, c);
    }
    return all;
}

std::span<const GltfExtension> gltfExtensions() {
    using enum Support;
    static constexpr std::array kExtensions{
        GltfExtension{
            "KHR_animation_pointer", drawn,
            "Factors of materials, texture transforms, lights, cameras, node transforms and "
            "visibility; other pointers, and rotations of normal maps, keep their values."},
        GltfExtension{"KHR_draco_mesh_compression", drawn,
                      "Bitstream version 2.2; uncompressed accessors are used if the file has them "
                      "and does not require the extension."},
        GltfExtension{"KHR_lights_punctual", drawn,
                      "Point, spot and directional lights with range and cone angles."},
        GltfExtension{
            "KHR_materials_anisotropy", drawn,
            "Highlights and reflections of the environment are stretched along the anisotropy; "
            "such surfaces do not mirror the scene."},
        GltfExtension{"KHR_materials_clearcoat", drawn,
                      "With its own normal map; flat coats mirror the scene."},
        GltfExtension{"KHR_materials_diffuse_transmission", drawn,
                      "Diffuse light of punctual lights and surroundings passes through."},
        GltfExtension{"KHR_materials_dispersion", drawn,
                      "Solid glass has an index of refraction for each of three primaries."},
        GltfExtension{"KHR_materials_emissive_strength", drawn,
                      "A factor on the emitted radiance, which may exceed 1."},
        GltfExtension{"KHR_materials_ior", drawn,
                      "The index of refraction sets reflectance and refraction."},
        GltfExtension{"KHR_materials_iridescence", drawn,
                      "A thin film whose thickness may have a texture."},
        GltfExtension{"KHR_materials_pbrSpecularGlossiness", approximated,
                      "Factors and textures are converted to metallic and roughness."},
        GltfExtension{"KHR_materials_sheen", drawn,
                      "Fibres over the base layer; the base is dimmed by what they reflect."},
        GltfExtension{"KHR_materials_specular", drawn,
                      "Factor and colour of the dielectric reflectance, with their textures."},
        GltfExtension{"KHR_materials_transmission", drawn,
                      "Glass: thin-walled, or solid with KHR_materials_volume."},
        GltfExtension{"KHR_materials_unlit", drawn,
                      "The base colour is shown as it is, without lights or reflections."},
        GltfExtension{"KHR_materials_variants", drawn,
                      "Requests select one by `variant`; without it every mesh has its default "
                      "material."},
        GltfExtension{"KHR_materials_volume", drawn, "Thickness and attenuation of solid glass."},
        GltfExtension{"KHR_materials_volume_scatter", refused,
                      "Volumes absorb but do not scatter."},
        GltfExtension{"KHR_mesh_quantization", drawn,
                      "8-bit and 16-bit vertex attributes, normalised or not."},
        GltfExtension{
            "KHR_node_visibility", drawn,
            "Meshes and lights at or below a hidden node are left out; clips may show and "
            "hide them, except skinned meshes."},
        GltfExtension{"KHR_texture_basisu", drawn,
                      "UASTC and ETC1S in KTX2 files are decoded and used instead of the fallback "
                      "image."},
        GltfExtension{"KHR_texture_transform", drawn,
                      "Offset, scale, rotation and texture coordinate set of each texture."},
        GltfExtension{"KHR_xmp", ignored, "Metadata does not change the image."},
        GltfExtension{"KHR_xmp_json_ld", ignored, "Metadata does not change the image."},
        GltfExtension{"EXT_lights_image_based", refused,
                      "Environment maps are loaded as separate files."},
        GltfExtension{"EXT_mesh_gpu_instancing", drawn,
                      "One instance for each translation, rotation and scale."},
        GltfExtension{"EXT_meshopt_compression", drawn,
                      "Compressed buffer views in every mode and with every filter of the codec's "
                      "version 0."},
        GltfExtension{"EXT_texture_avif", drawn, "Still AVIF images, before the fallback."},
        GltfExtension{"EXT_texture_webp", drawn, "Still WebP images, before the fallback."},
        GltfExtension{"FB_ngon_encoding", ignored, "Polygons are drawn as their triangles."},
        GltfExtension{"MSFT_lod", refused, "Levels of detail are not selected."},
        GltfExtension{"MSFT_texture_dds", refused, "DDS images are not decoded."},
    };
    return kExtensions;
}

Support gltfSupport(std::string_view extension) {
    for (const GltfExtension& known : gltfExtensions()) {
        if (known.name == extension) return known.support;
    }
    return Support::refused;
}

std::string_view nameOf(Support support) {
    constexpr std::array<std::string_view, 4> kNames{"drawn", "approximated", "ignored", "refused"};
    return kNames[static_cast<std::size_t>(support)];
}

}  // namespace clerestory
