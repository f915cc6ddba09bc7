// What a scene's owner says beside the model: MODEL.clerestory.json with material overrides and
// placed probes, and the same words in a glTF file's extras. Whatever is wrong in it is a warning
// that names the place; the model never suffers.
#pragma once

#include "scene/import/base/json_fields.h"
#include "scene/import/base/scene_folder.h"
#include "scene/scene.h"

#include <string>

namespace clerestory {

// The side file's name for a model's: "hall.gltf" -> "hall.clerestory.json".
std::string sidecarName(const std::string& modelName);

// Reads it, if it is there, and applies it for good to a sound scene, which it may leave in need of
// finishScene(). Returns whether it was there.
bool applySidecar(Scene& scene, const SceneFolder& folder, const std::string& modelName);

// A glTF material's extras: reflection, probe, environmentMap, environmentRotation. Others' notes
// are left alone.
void readMaterialExtras(const Json& extras, Material& material, Scene& scene);

// A glTF node's extras: "probe", an object as in the side file, at this node.
void readNodeExtras(const Json& extras, Index node, Scene& scene);

// Materials that name a probe which is not there lose it, with a warning. Whether there were any.
bool dropUnknownProbes(Scene& scene);

}  // namespace clerestory
