// Sets the limits first, then imports, then writes the blob to the result descriptor.
#include "scene/import/child.h"

#include "scene/import/cache/blob.h"
#include "scene/import/in_process.h"
#include "scene/import/sandbox/jail.h"
#include "scene/import/sandbox/sanitizer.h"
#include "scene/import/sandbox/wire.h"

#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>

namespace clerestory {
namespace {

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
}

// The folder that the child may read: of six cube faces, or of the file.
std::filesystem::path folderOf(const std::filesystem::path& file) {
    std::error_code error;
    if (std::filesystem::is_directory(file, error)) return file;
    return file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
}

}  // namespace

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
    enterJail(folderOf(file));
    const auto report = [&](const std::string& line) {
        writeAll(progress, line.data(), line.size());
    };
    const auto fail = [&](ImportError::Reason reason, const std::string& message) {
        report(errorLine(reason, message));
        return kChildRefused;
    };
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
            [&](const FileDependency& dependency) { dependencies += dependencyLine(dependency); });
        report(dependencies);
        report(progressLine({"handing over", 0.9}));
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
