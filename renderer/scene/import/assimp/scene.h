// OBJ, FBX, COLLADA, PLY, STL and 3DS through Assimp -> Scene.
#pragma once

#include "scene/import/base/scene_folder.h"
#include "scene/import/base/types.h"
#include "scene/scene.h"

namespace clerestory {

// `file` is in `folder`. `extension` is the file's, lower case; it selects the reader. Does not set
// the title. Throws ImportError. May crash: Assimp 5.2.5 does on hostile files.
Scene assimpScene(const std::string& file, const std::string& extension, const SceneFolder& folder,
                  const ImportLimits& limits, const ProgressCallback& progress);

}  // namespace clerestory
