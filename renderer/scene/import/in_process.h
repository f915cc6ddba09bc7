// The import in the calling process, without a child process and without its protection: what the
// child runs, and what tests and benchmarks call. May crash on hostile files. And the main function
// of the child process.
#pragma once

#include "scene/environment.h"
#include "scene/import/base/scene_folder.h"
#include "scene/import/base/types.h"
#include "scene/scene.h"

#include <filesystem>
#include <functional>

namespace clerestory {

using DependencyCallback = std::function<void(const FileDependency&)>;

// `dependencies` is called once for each file that the importer looked for. sceneOfFile: as
// ImportOptions::scene. Throws ImportError.
Scene importSceneInProcess(const std::filesystem::path& file, const ImportLimits& limits = {},
                           const ProgressCallback& progress = {},
                           const DependencyCallback& dependencies = {},
                           const std::string& sceneOfFile = {});

// The map has no name. Throws ImportError.
EnvironmentMap loadEnvironmentInProcess(const std::filesystem::path& fileOrFolder,
                                        const ImportLimits& limits = {});

// `clerestory import-child FILE --result-fd N --progress-fd M [--limits TEXT] [--as environment]
// [--scene TEXT]`.
// Sets the process's limits, enters the jail, imports FILE and writes the blob to the result
// descriptor. Returns an exit code (sandbox/process.h).
int importChildMain(int argc, char** argv);

}  // namespace clerestory
