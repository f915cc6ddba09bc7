// The vertex format of scenes.
#pragma once

#include <glm/glm.hpp>

namespace clerestory {

// Attributes that the file does not have are generated or set to a neutral value by addMesh().
struct Vertex {
    glm::vec3 position{0.0f};
    glm::vec3 normal{0.0f, 0.0f, 1.0f};         // unit
    glm::vec4 tangent{1.0f, 0.0f, 0.0f, 1.0f};  // unit; w is the sign of the bitangent
    glm::vec2 texCoord0{0.0f};
    glm::vec2 texCoord1{0.0f};
    glm::vec4 color{1.0f};  // linear, multiplies baseColor
};
static_assert(sizeof(Vertex) == 72);

}  // namespace clerestory
