#include "server/scenes/shader_cache.h"

#include "scene/hash.h"
#include "server/base/log.h"
#include "server/base/process.h"
#include "server/scenes/cache_folder.h"

#include <cstdlib>
#include <cstring>
#include <fstream>

namespace clerestory {
namespace {

constexpr const char* kFolder = "MESA_SHADER_CACHE_DIR";
constexpr const char* kDisable = "MESA_SHADER_CACHE_DISABLE";
// Of NVIDIA's driver.
constexpr const char* kOtherFolder = "__GL_SHADER_DISK_CACHE_PATH";
constexpr const char* kOtherSwitch = "__GL_SHADER_DISK_CACHE";
// Mesa looks for an entry in one database after the other, by default in 50, with 20 system calls
// for each.
constexpr const char* kDatabases = "MESA_DISK_CACHE_DATABASE_NUM_PARTS";
constexpr const char* kPerformance = "GALLIVM_PERF";
constexpr const char* kFast = "nopt";

bool writable(const std::filesystem::path& folder) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    const std::filesystem::path probe = folder / "clerestory-write-probe";
    const bool made = std::ofstream(probe).put('\n').flush().good();
    std::filesystem::remove(probe, error);
    return made;
}

void disable() {
    setenv(kDisable, "true", 1);
    setenv(kOtherSwitch, "0", 0);
}

// Empty if there is no cache.
std::filesystem::path markOf(const std::string& what) {
    const char* folder = std::getenv(kFolder);
    if (!folder || std::getenv(kDisable)) return {};
    return std::filesystem::path(folder) / "clerestory" /
           (hashWordOf(buildId() + '\n' + what) + (compilesFast() ? ".fast" : ".optimized"));
}

}  // namespace

void useShaderCache(const std::filesystem::path& folder) {
    setenv(kDatabases, "1", 0);
    if (std::getenv(kFolder) || std::getenv(kDisable)) return;
    const std::filesystem::path chosen = folder.empty() ? userCache() / "shaders" : folder;
    if (folder == "none" || userCache().empty()) {
        disable();
    } else if (writable(chosen)) {
        setenv(kFolder, chosen.c_str(), 1);
        setenv(kOtherFolder, chosen.c_str(), 0);
    } else {
        logWarning({"shader cache: cannot write to \"", chosen.string(),
                    "\"; every start compiles its shaders again (--shader-cache DIR)"});
        disable();
    }
}

bool keepsShaders() {
    return !std::getenv(kDisable);
}

void compileFast() {
    setenv(kPerformance, kFast, 0);
}

bool compilesFast() {
    const char* value = std::getenv(kPerformance);
    return value && std::strstr(value, kFast);
}

bool compiledBefore(const std::string& what) {
    const std::filesystem::path mark = markOf(what);
    std::error_code error;
    return !mark.empty() && std::filesystem::exists(mark, error);
}

void setCompiled(const std::string& what) {
    const std::filesystem::path mark = markOf(what);
    if (mark.empty()) return;
    std::error_code error;
    std::filesystem::create_directories(mark.parent_path(), error);
    std::ofstream(mark).put('\n');
}

}  // namespace clerestory
