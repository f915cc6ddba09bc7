// A glTF 2.0 file -> Scene.
#pragma once

#include "scene/import/base/scene_folder.h"
#include "scene/import/base/types.h"
#include "scene/scene.h"

namespace clerestory {

// `file` is the content of a .gltf or .glb. `wanted`: as ImportOptions::scene. The title is left to
// the caller. Throws ImportError.
Scene gltfScene(std::string file, const std::string& wanted, const SceneFolder& folder,
                const ImportLimits& limits, const ProgressCallback& progress);

}  // namespace clerestory
