// Changes valid files so that Assimp's readers accept them.
#pragma once

#include <string>
#include <string_view>

namespace clerestory {

// COLLADA without spaces between a tag and its first number, which XML allows and Assimp rejects;
// with a name for each camera and light, without which Assimp passes over their content; and with
// lenses that Assimp understands.
std::string acceptedCollada(std::string_view xml);

// OBJ without indentation, because Assimp passes over indented vertices. A file with vertices and
// no elements is a cloud of points, which Assimp rejects: each vertex becomes a point element, with
// its normal if there is one for each.
std::string acceptedObj(std::string_view obj);

}  // namespace clerestory
