// The sidecar file of a scene, MODEL.clerestory.json, with changes of materials and lights, and
// probes; and the same fields in the extras of a glTF file. Every error in them is a warning with a
// JSON Pointer; the scene is imported without the invalid field.
#pragma once

#include "scene/import/base/json_fields.h"
#include "scene/import/base/scene_folder.h"
#include "scene/scene.h"

#include <string>

namespace clerestory {

// The sidecar's name for a model's name: "hall.gltf" -> "hall.clerestory.json".
std::string sidecarName(const std::string& modelName);

// Reads the sidecar, if it exists, and applies it to a valid scene, which then needs finishScene()
// again. Returns whether it exists.
bool applySidecar(Scene& scene, const SceneFolder& folder, const std::string& modelName);

// A glTF material's extras: reflection, probe, environmentMap, environmentRotation, mapBlur. Other
// members are ignored.
void readMaterialExtras(const Json& extras, Material& material, Scene& scene);

// A glTF node's extras: "probe", an object as in the sidecar, attached to this node.
void readNodeExtras(const Json& extras, Index node, Scene& scene);

// A light's extras: "radius", as in the sidecar.
void readLightExtras(const Json& extras, Light& light, Scene& scene);

// Removes references of materials to unknown probes, with a warning. Returns whether there were
// any.
bool dropUnknownProbes(Scene& scene);

}  // namespace clerestory
