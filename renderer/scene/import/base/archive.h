// A scene and its files in a .zip or .tar archive. Unpacked in memory, in the importing process:
// nothing in it can refer to a path on disk.
#pragma once

#include "scene/import/base/types.h"

#include <map>
#include <string>

namespace clerestory {

bool isArchive(const std::string& extension);  // lower case, without the dot

struct UnpackedScene {
    std::string name;                          // of the scene file, relative to its folder
    std::map<std::string, std::string> files;  // in and below that folder, by relative path
};

// Finds the scene file (.glb, .gltf, .obj) with the fewest parent folders, and the files in its
// folder. Throws ImportError for links, devices, names that lead out of the archive, duplicate
// names, too many or too large files, no scene or several.
UnpackedScene unpackedScene(const std::string& archive, const ImportLimits& limits);

}  // namespace clerestory
