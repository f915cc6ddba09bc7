// The words between importScene() and its child: exit codes, the limits, progress and error lines.
#pragma once

#include "scene/import/file_reading.h"
#include "scene/import/import.h"

#include <optional>
#include <string>

namespace clerestory {

inline constexpr int kChildRefused = 3;  // an error line says why
inline constexpr int kChildBadUsage = 64;

std::string encoded(const ImportLimits& limits);
ImportLimits decodedLimits(const std::string& text);  // defaults where the text has none

std::string progressLine(const ImportProgress& progress);
std::string errorLine(ImportError::Reason reason, const std::string& message);

std::optional<ImportProgress> readProgress(const std::string& line);
std::optional<ImportError> readError(const std::string& line);

std::string readingLine(const FileReading& reading);
std::optional<FileReading> readReading(const std::string& line);

}  // namespace clerestory
