// OBJ, FBX, COLLADA, PLY, STL and 3DS through Assimp -> Scene.
#pragma once

#include "scene/import/import.h"
#include "scene/import/scene_folder.h"

namespace clerestory {

// `file` lies in `folder`; `extension` is its own, lower case, and alone chooses the reader. The
// title is left to the caller. Throws ImportError. May crash: Assimp 5.2.5 does on hostile files.
Scene assimpScene(const std::string& file, const std::string& extension, const SceneFolder& folder,
                  const ImportLimits& limits, const ProgressCallback& progress);

}  // namespace clerestory
