// Files of environment maps -> EnvironmentMap, in the calling process.
#pragma once

#include "scene/environment.h"
#include "scene/import/base/types.h"

#include <filesystem>

namespace clerestory {

// The formats are those of loadEnvironment() in import.h. The map has no name. Throws ImportError.
EnvironmentMap readEnvironmentFile(const std::filesystem::path& fileOrFolder,
                                   const ImportLimits& limits);

}  // namespace clerestory
