// OBJ, FBX, COLLADA, PLY, STL and 3DS through Assimp -> Scene.
#pragma once

#include "scene/import/base/scene_folder.h"
#include "scene/import/base/types.h"
#include "scene/scene.h"

namespace clerestory {

// `file` lies in `folder`; `extension` is its own, lower case, and alone chooses the reader. The
// title is left to the caller. Throws ImportError. May crash: Assimp 5.2.5 does on hostile files.
Scene assimpScene(const std::string& file, const std::string& extension, const SceneFolder& folder,
                  const ImportLimits& limits, const ProgressCallback& progress);

}  // namespace clerestory
