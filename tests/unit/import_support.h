// Shared by the import tests: a temporary folder, and the repository's scenes.
#pragma once

#include "scene/import/import.h"
#include "scene/import/in_process.h"
#include "tests/support/temporary_folder.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace clerestory {

inline std::filesystem::path ownScene(const std::string& name) {
    return std::filesystem::path(CLERESTORY_SOURCE_DIR) / "tests/scenes/import" / name;
}

inline std::filesystem::path sharedScene(const std::string& name) {
    return std::filesystem::path(CLERESTORY_SHARED_SCENES) / name;
}

// The error of importing a file that must fail.
inline ImportError refusal(const std::filesystem::path& file, const ImportOptions& options = {}) {
    try {
        importScene(file, options);
    } catch (const ImportError& error) {
        return error;
    }
    ADD_FAILURE() << file << " was imported";
    return {ImportError::Reason::crashed, "was imported"};
}

inline const ImportWarning* warning(const Scene& scene, const std::string& code) {
    for (const ImportWarning& w : scene.warnings) {
        if (w.code == code) return &w;
    }
    return nullptr;
}

inline const Material* material(const Scene& scene, const std::string& name) {
    for (const Material& m : scene.materials) {
        if (m.name == name) return &m;
    }
    ADD_FAILURE() << "no material " << name;
    static const Material none;
    return &none;
}

}  // namespace clerestory

#define CLERESTORY_NEEDS(file) \
    if (!std::filesystem::exists(file)) GTEST_SKIP() << (file) << " is not there"
