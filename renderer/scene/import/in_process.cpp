// Chooses the reader by the file's extension. The child process sets its limits first, then
// imports, then writes the blob to the result descriptor.
#include "scene/import/in_process.h"

#include "scene/import/assimp/scene.h"
#include "scene/import/base/clean_text.h"
#include "scene/import/base/imported_scene.h"
#include "scene/import/base/scene_folder.h"
#include "scene/import/base/sidecar.h"
#include "scene/import/base/types.h"
#include "scene/import/cache/blob.h"
#include "scene/import/gltf/scene.h"
#include "scene/import/sandbox/jail.h"
#include "scene/import/sandbox/process.h"
#include "scene/import/textures/environment_reader.h"

#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>

namespace clerestory {
namespace {

Scene sceneIn(const SceneFolder& folder, const std::string& name, const std::string& wanted,
              const ImportLimits& limits, const ProgressCallback& progress) {
    const std::string extension = lowerExtension(name);
    const bool isGltf = extension == "gltf" || extension == "glb";
    if (!isGltf && !folder.has(name)) {
        throw ImportError(ImportError::Reason::notFound,
                          "'" + cleanText(name) + "' is not a readable file");
    }
    if (!isGltf && !wanted.empty()) {
        throw ImportError(ImportError::Reason::notFound, "only glTF files have several scenes");
    }
    Scene scene = isGltf ? gltfScene(folder.read(name), wanted, folder, limits, progress)
                         : assimpScene(name, extension, folder, limits, progress);
    finishScene(scene);
    const bool sidecarApplied = applySidecar(scene, folder, name);
    if (dropUnknownProbes(scene) || sidecarApplied) finishScene(scene);
    requireDrawable(scene, limits);
    scene.title = cleanText(std::filesystem::path(name).stem().string());
    if (!wanted.empty() && !scene.scenesOfFile.empty()) {
        scene.title = cleanText(scene.title + ": " + scene.scenesOfFile[scene.sceneOfFile]);
    }
    return scene;
}

void writeAll(int descriptor, const void* bytes, std::size_t count) {
    const char* at = static_cast<const char*>(bytes);
    while (count > 0) {
        const ssize_t written = write(descriptor, at, count);
        if (written < 0 && errno == EINTR) {
            continue;
        }
        if (written <= 0) {
            throw ImportError(ImportError::Reason::memory, "the result could not be written");
        }
        at += written;
        count -= static_cast<std::size_t>(written);
    }
}

void limit(__rlimit_resource what, std::uint64_t value) {
    const rlimit both{value, value};
    setrlimit(what, &both);
}

void setProcessLimits(const ImportLimits& limits) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    limit(RLIMIT_CORE, 0);
    limit(RLIMIT_CPU, static_cast<std::uint64_t>(limits.cpu.count()));
    limit(RLIMIT_NOFILE, 64);
    if (!kSanitized) limit(RLIMIT_AS, limits.addressSpaceBytes);
    // The result is a file in memory, which the limit of address space does not count.
    std::signal(SIGXFSZ, SIG_IGN);
    limit(RLIMIT_FSIZE, limits.addressSpaceBytes);
}

// The folder that the child may read: of six cube faces, or of the file.
std::filesystem::path folderOf(const std::filesystem::path& file) {
    std::error_code error;
    if (std::filesystem::is_directory(file, error)) return file;
    return file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
}

}  // namespace

Scene importSceneInProcess(const std::filesystem::path& file, const ImportLimits& limits,
                           const ProgressCallback& progress, const DependencyCallback& dependencies,
                           const std::string& sceneOfFile) {
    const std::string extension = lowerExtension(file);
    const auto& known = importableExtensions();
    if (std::find(known.begin(), known.end(), extension) == known.end()) {
        throw ImportError(ImportError::Reason::unsupported,
                          "files with the extension '." + cleanText(extension) +
                              "' are not supported; scenes are " +
                              extensionsText(FormatUse::scene) + ", archives of one " +
                              extensionsText(FormatUse::archive));
    }
    if (progress) {
        progress({"reading", 0.0});
    }
    const SceneFolder folder(file.parent_path(), limits.fileBytes, limits.maxFiles);
    const std::string name = file.filename().string();
    Scene scene;
    if (isArchive(extension)) {
        UnpackedScene unpacked = unpackedScene(folder.read(name), limits);
        scene = sceneIn(SceneFolder(std::move(unpacked.files)), unpacked.name, sceneOfFile, limits,
                        progress);
    } else {
        scene = sceneIn(folder, name, sceneOfFile, limits, progress);
    }
    if (dependencies) {
        for (const FileDependency& each : folder.dependencies()) dependencies(each);
    }
    return scene;
}

EnvironmentMap loadEnvironmentInProcess(const std::filesystem::path& fileOrFolder,
                                        const ImportLimits& limits) {
    return readEnvironmentFile(fileOrFolder, limits);
}

int importChildMain(int argc, char** argv) {
    std::map<std::string, std::string> options;
    std::string file;
    for (int i = 2; i < argc; ++i) {
        const std::string word = argv[i];
        if (word.starts_with("--") && i + 1 < argc) {
            options[word] = argv[++i];
        } else {
            file = word;
        }
    }
    const auto descriptor = [&](const char* name) {
        const auto found = options.find(name);
        return found == options.end() ? -1 : std::atoi(found->second.c_str());
    };
    const int result = descriptor("--result-fd");
    const int progress = descriptor("--progress-fd");
    if (file.empty() || result < 0 || progress < 0) {
        return kChildBadUsage;
    }
    const ImportLimits limits = decodedLimits(options["--limits"]);
    setProcessLimits(limits);
    // Libraries print what they find in damaged files. Standard output is /dev/null.
    if (!kSanitized) dup2(STDOUT_FILENO, STDERR_FILENO);
    const JailSupport possible = jailSupport(), enforced = enterJail(folderOf(file));
    const auto report = [&](const std::string& line) {
        writeAll(progress, line.data(), line.size());
    };
    const auto fail = [&](ImportError::Reason reason, const std::string& message) {
        report(errorLine(reason, message));
        return kChildRefused;
    };
    if (enforced.landlock != possible.landlock ||
        enforced.systemCallFilter != possible.systemCallFilter) {
        return fail(ImportError::Reason::crashed, "the importer could not be confined");
    }
    try {
        const auto writeResult = [&](const void* bytes, std::size_t count) {
            writeAll(result, bytes, count);
        };
        if (options["--as"] == "environment") {
            writeEnvironment(loadEnvironmentInProcess(file, limits), writeResult);
            return 0;
        }
        std::string dependencies;
        const Scene scene = importSceneInProcess(
            file, limits, [&](const ImportProgress& step) { report(progressLine(step)); },
            [&](const FileDependency& dependency) { dependencies += dependencyLine(dependency); },
            options["--scene"]);
        report(dependencies);
        report(progressLine({"transferring", 0.9}));
        writeScene(scene, writeResult);
        return 0;
    } catch (const ImportError& error) {
        return fail(error.reason(), error.what());
    } catch (const std::bad_alloc&) {
        return fail(ImportError::Reason::memory,
                    "the file needs more memory than an import is allowed to use");
    } catch (const std::length_error&) {
        return fail(ImportError::Reason::memory,
                    "the file needs more memory than an import is allowed to use");
    } catch (const std::exception&) {
        return fail(ImportError::Reason::malformed, "the file could not be read");
    }
}

}  // namespace clerestory
