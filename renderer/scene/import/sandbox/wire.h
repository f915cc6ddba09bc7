// The protocol between runImportChild() and the child: exit codes, and lines with progress, errors
// and file dependencies. Each function that writes a line has one that reads it.
#pragma once

#include "scene/import/base/scene_folder.h"
#include "scene/import/base/types.h"

#include <optional>
#include <string>

namespace clerestory {

inline constexpr int kChildRefused = 3;  // an error line has the reason
inline constexpr int kChildBadUsage = 64;

std::string progressLine(const ImportProgress& progress);
std::string errorLine(ImportError::Reason reason, const std::string& message);
std::string dependencyLine(const FileDependency& dependency);

// Nothing for a line of another kind, or a malformed one. Texts are cleaned (base/cleaning.h).
std::optional<ImportProgress> readProgress(const std::string& line);
std::optional<ImportError> readError(const std::string& line);
std::optional<FileDependency> readDependency(const std::string& line);

}  // namespace clerestory
