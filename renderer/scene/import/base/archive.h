// A scene and its files in one: a .zip or a .tar. Unpacked in memory only, in the importing
// process, so that nothing in it can name a place on a disk.
#pragma once

#include "scene/import/base/types.h"

#include <map>
#include <string>

namespace clerestory {

bool isArchive(const std::string& extension);  // lower case, without the dot

struct UnpackedScene {
    std::string name;                          // of the scene file, relative to its folder
    std::map<std::string, std::string> files;  // of that folder and below it, by relative path
};

// The one scene file (.glb, .gltf, .obj) that lies least deep, and what lies in its folder. Throws
// ImportError: links, devices, names that lead out, doubled names, too many or too large files, no
// scene or more than one.
UnpackedScene unpackedScene(const std::string& archive, const ImportLimits& limits);

}  // namespace clerestory
