#include "scene/import/gltf/extensions.h"

#include <array>

namespace clerestory {

std::span<const GltfExtension> gltfExtensions() {
    using enum Support;
    static constexpr std::array kExtensions{
        GltfExtension{
            "KHR_animation_pointer", ignored,
            "Animations of node transforms and morph weights are played; animated pointers "
            "keep their initial values."},
        GltfExtension{"KHR_draco_mesh_compression", refused,
                      "Compressed meshes are not decoded; a mesh with uncompressed accessors as a "
                      "fallback is drawn from these."},
        GltfExtension{"KHR_lights_punctual", drawn,
                      "Point, spot and directional lights with range and cone angles."},
        GltfExtension{"KHR_materials_anisotropy", ignored, "Highlights are isotropic."},
        GltfExtension{"KHR_materials_clearcoat", ignored,
                      "The base layer is drawn without a coat."},
        GltfExtension{"KHR_materials_diffuse_transmission", refused,
                      "Light does not scatter through a surface."},
        GltfExtension{"KHR_materials_dispersion", ignored,
                      "The index of refraction is the same for all wavelengths."},
        GltfExtension{"KHR_materials_emissive_strength", drawn,
                      "A factor on the emitted radiance, which may exceed 1."},
        GltfExtension{"KHR_materials_ior", drawn,
                      "The index of refraction sets reflectance and refraction."},
        GltfExtension{"KHR_materials_iridescence", ignored, "Thin films are not drawn."},
        GltfExtension{"KHR_materials_pbrSpecularGlossiness", approximated,
                      "Factors are converted to metallic and roughness; the specular-glossiness "
                      "texture is not used."},
        GltfExtension{"KHR_materials_sheen", ignored, "Cloth is drawn without its sheen layer."},
        GltfExtension{
            "KHR_materials_specular", approximated,
            "Factor and colour of the dielectric reflectance; their textures are not used."},
        GltfExtension{"KHR_materials_transmission", drawn,
                      "Glass: thin-walled, or solid with KHR_materials_volume."},
        GltfExtension{"KHR_materials_unlit", drawn,
                      "The base colour is shown as it is, without lights or reflections."},
        GltfExtension{"KHR_materials_variants", ignored,
                      "Every mesh has its default material; a request may override it."},
        GltfExtension{"KHR_materials_volume", drawn, "Thickness and attenuation of solid glass."},
        GltfExtension{"KHR_materials_volume_scatter", refused,
                      "Volumes absorb but do not scatter."},
        GltfExtension{"KHR_mesh_quantization", drawn,
                      "8-bit and 16-bit vertex attributes, normalised or not."},
        GltfExtension{"KHR_node_visibility", refused, "Hidden nodes would be drawn."},
        GltfExtension{
            "KHR_texture_basisu", ignored,
            "The fallback image is used; a texture without one is left out with a warning."},
        GltfExtension{"KHR_texture_transform", drawn,
                      "Offset, scale, rotation and texture coordinate set of each texture."},
        GltfExtension{"KHR_xmp", ignored, "Metadata does not change the image."},
        GltfExtension{"KHR_xmp_json_ld", ignored, "Metadata does not change the image."},
        GltfExtension{"EXT_lights_image_based", refused,
                      "Environment maps are loaded as files of their own."},
        GltfExtension{"EXT_mesh_gpu_instancing", drawn,
                      "One instance for each translation, rotation and scale."},
        GltfExtension{"EXT_meshopt_compression", refused,
                      "Compressed buffer views are not decoded; fallback buffers are read."},
        GltfExtension{"EXT_texture_avif", refused, "AVIF images are not decoded."},
        GltfExtension{
            "EXT_texture_webp", ignored,
            "The fallback image is used; a texture without one is left out with a warning."},
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
