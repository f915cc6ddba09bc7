// Files -> Scene. The only room that knows file formats.
//
// importScene() runs the reader in a child process of its own (the libraries underneath crash, hang
// and eat memory on small hostile files) and takes back one flat, checked Scene. Nothing outside
// the scene file's folder is opened.
#pragma once

#include "scene/environment.h"
#include "scene/import/formats.h"
#include "scene/scene.h"

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

namespace clerestory {

struct ImportLimits {
    std::chrono::milliseconds wallClock{60000};
    std::chrono::seconds cpu{60};
    std::uint64_t addressSpaceBytes = 6ull << 30;
    std::uint64_t fileBytes = 512ull << 20;  // of each; all together may have four times as many
    std::uint64_t maxTriangles = 20'000'000;
    std::uint64_t maxNodes = 200'000;
    std::uint64_t maxImagePixels = 64'000'000;
    std::uint64_t maxFiles = 4096;  // read for one scene, or packed in one archive
};

// Why a file gave no scene. `what()` is for people and holds no path of this machine.
class ImportError : public std::runtime_error {
public:
    enum class Reason { notFound, unsupported, malformed, crashed, timedOut, memory, limit };
    ImportError(Reason reason, const std::string& message)
        : std::runtime_error(message), reason_(reason) {}
    Reason reason() const { return reason_; }

private:
    Reason reason_;
};

std::string_view nameOf(ImportError::Reason reason);  // as the enumerator is called

struct ImportProgress {
    std::string stage;      // "reading", "textures", "meshes", "handing over"
    double progress = 0.0;  // 0..1 over all stages
};
using ProgressCallback = std::function<void(const ImportProgress&)>;

class SceneCache;

struct ImportOptions {
    std::filesystem::path importer;  // the clerestory program; empty: /proc/self/exe
    ImportLimits limits;
    std::shared_ptr<SceneCache> cache;  // of what was imported before; null: none
};

// Taken from the cache, when that has what the file and all files beside it would give. Throws
// ImportError.
Scene importScene(const std::filesystem::path& file, const ImportOptions& options = {},
                  const ProgressCallback& progress = {});

struct FileReading;
using ReadingCallback = std::function<void(const FileReading&)>;

// The same work in this process; what the child runs. `readings` is told what files it came from
// (file_reading.h). Throws ImportError, and may crash.
Scene importSceneHere(const std::filesystem::path& file, const ImportLimits& limits = {},
                      const ProgressCallback& progress = {}, const ReadingCallback& readings = {});

// The child's main: `clerestory import-child FILE --result-fd N --progress-fd M [--as
// environment]`. Returns an exit code.
int importChildMain(int argc, char** argv);

// An environment map: .hdr or .exr (equirectangular), a cube map as .ktx or .ktx2, or a folder with
// px nx py ny pz nz (.hdr .exr .png .jpg). Read in a child process as scenes are. Faces larger than
// kLargestImportedFace are halved. Throws ImportError.
EnvironmentMap loadEnvironment(const std::filesystem::path& fileOrFolder,
                               const ImportOptions& options = {});
inline constexpr std::uint32_t kLargestImportedFace = 1024;  // texels

// The same work in this process, without the map's name; what the child runs.
EnvironmentMap loadEnvironmentHere(const std::filesystem::path& fileOrFolder,
                                   const ImportLimits& limits = {});

}  // namespace clerestory
