// Runs an import in a child process: starts it, reads its progress, stops it at the deadline and
// takes its result; and the protocol with it: exit codes, and lines with progress, errors and file
// dependencies.
//
// Does not: interpret the result (cache/blob.h), confine the child, which does that itself
// (sandbox/jail.h).
#pragma once

#include "scene/import/base/scene_folder.h"
#include "scene/import/base/types.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace clerestory {

inline constexpr int kChildRefused = 3;  // an error line has the reason
inline constexpr int kChildBadUsage = 64;

std::string progressLine(const ImportProgress& progress);
std::string errorLine(ImportError::Reason reason, const std::string& message);
std::string dependencyLine(const FileDependency& dependency);

// Nothing for a line of another kind, or a malformed one. Texts are cleaned (cleanText()).
std::optional<ImportProgress> readProgress(const std::string& line);
std::optional<ImportError> readError(const std::string& line);
std::optional<FileDependency> readDependency(const std::string& line);

// The child's output, sealed against modification, and the files that it looked for.
struct ChildResult {
    std::shared_ptr<const void> owner;  // of `bytes`
    std::span<const std::byte> bytes;
    std::vector<FileDependency> dependencies;
};

// kind: "scene" or "environment". scene: as ImportOptions::scene. program: the clerestory program;
// empty: /proc/self/exe. Throws ImportError for everything that is the file's fault, and
// std::runtime_error for system calls that failed.
ChildResult runImportChild(const std::filesystem::path& file, const char* kind,
                           const std::string& scene, const std::filesystem::path& program,
                           const ImportLimits& limits, const ProgressCallback& progress);

}  // namespace clerestory
