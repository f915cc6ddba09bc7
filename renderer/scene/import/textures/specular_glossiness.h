// Materials of KHR_materials_pbrSpecularGlossiness as metallic and roughness: by numbers and by
// images.
//
// Formulae: the definitions of both models in glTF 2.0, appendix B, and in the extension, with the
// reflectance of a dielectric of 0.04, solved for the metallic share (a quadratic equation in the
// brightness of both colours).
#pragma once

#include "scene/material.h"

#include <glm/glm.hpp>

namespace clerestory {

struct MetallicBase {
    glm::vec3 color{0.0f};  // linear
    float metallic = 0.0f;  // in [0, 1]
};
// diffuse, specular: linear, in [0, 1].
MetallicBase metallicBase(const glm::vec3& diffuse, const glm::vec3& specular);

struct SpecularGlossinessFactors {
    glm::vec3 diffuse{1.0f}, specular{1.0f};  // linear
    float glossiness = 1.0f;
};

// Level 0 in the size of the larger image. diffuse: sRGB with alpha; specular: sRGB, with the
// glossiness as alpha; null: white, opaque.
// The base colour (sRGB, alpha that of the diffuse image), or roughness in green and metallic in
// blue.
enum class ConvertedTo { baseColor, metallicRoughness };
TextureImage converted(const TextureImage* diffuse, const TextureImage* specular,
                       const SpecularGlossinessFactors& factors, ConvertedTo result);

}  // namespace clerestory
