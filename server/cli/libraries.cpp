#include "server/cli/config.h"

#include "film/film.h"
#include "rays/embree.h"
#include "renderer.h"
#include "server/base/process.h"

#include <archive.h>
#include <assimp/version.h>
#include <avif/avif.h>
#include <draco/core/draco_version.h>
#include <meshoptimizer.h>
#include <openssl/crypto.h>
#include <openssl/opensslv.h>
#include <png.h>
#include <seccomp.h>
#include <spdlog/version.h>
#include <webp/decode.h>
#include <zlib.h>
#include <zstd.h>
#include <CLI/Version.hpp>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <memory>

namespace clerestory {
namespace {

std::string dotted(unsigned long a, unsigned long b, unsigned long c) {
    return std::to_string(a) + "." + std::to_string(b) + "." + std::to_string(c);
}

std::string seccompVersion() {
    const scmp_version* version = seccomp_version();
    return version ? dotted(version->major, version->minor, version->micro) : "";
}

std::string embreeVersion() {
    const std::unique_ptr<RTCDeviceTy, void (*)(RTCDevice)> device(rtcNewDevice("threads=1"),
                                                                   rtcReleaseDevice);
    if (!device) return "";
    const auto part = [&](RTCDeviceProperty property) {
        return static_cast<unsigned long>(rtcGetDeviceProperty(device.get(), property));
    };
    return dotted(part(RTC_DEVICE_PROPERTY_VERSION_MAJOR), part(RTC_DEVICE_PROPERTY_VERSION_MINOR),
                  part(RTC_DEVICE_PROPERTY_VERSION_PATCH));
}

std::string webpVersion() {
    const auto version = static_cast<unsigned>(WebPGetDecoderVersion());
    return dotted(version >> 16, version >> 8 & 0xff, version & 0xff);
}

// Creates a context, which is required to query the version.
std::string openglVersion() {
    try {
        const RendererIdentity found = Renderer({}).identity();
        return found.version + ", " + found.renderer;
    } catch (const std::exception& error) {
        return std::string("not available: ") + error.what();
    }
}

}  // namespace

std::vector<LibraryVersion> libraryVersions() {
    const std::string archiveVersion = archive_version_string();  // "libarchive 3.6.2"
    return {
        {"assimp", CLERESTORY_ASSIMP_VERSION,
         dotted(aiGetVersionMajor(), aiGetVersionMinor(), aiGetVersionPatch())},
        {"CLI11", CLI11_VERSION, ""},
        {"cpp-httplib", CLERESTORY_HTTPLIB_VERSION, ""},
        {"draco", draco::kDracoVersion, ""},
        {"embree", RTC_VERSION_STRING, embreeVersion()},
        {"glm",
         dotted(GLM_VERSION_MAJOR, GLM_VERSION_MINOR, GLM_VERSION_PATCH) + "." +
             std::to_string(GLM_VERSION_REVISION),
         ""},
        {"libarchive", ARCHIVE_VERSION_ONLY_STRING,
         archiveVersion.substr(archiveVersion.rfind(' ') + 1)},
        {"libavformat", libavformatBuilt(), libavformatLoaded()},
        {"libavif", dotted(AVIF_VERSION_MAJOR, AVIF_VERSION_MINOR, AVIF_VERSION_PATCH),
         avifVersion()},
        {"libjpeg-turbo", CLERESTORY_JPEG_VERSION, ""},
        {"libpng", PNG_LIBPNG_VER_STRING, png_get_libpng_ver(nullptr)},
        {"libseccomp", dotted(SCMP_VER_MAJOR, SCMP_VER_MINOR, SCMP_VER_MICRO), seccompVersion()},
        {"libwebp", CLERESTORY_WEBP_VERSION, webpVersion()},
        {"meshoptimizer",
         dotted(MESHOPTIMIZER_VERSION / 1000, MESHOPTIMIZER_VERSION / 10 % 100,
                MESHOPTIMIZER_VERSION % 10),
         ""},
        {"nlohmann-json",
         dotted(NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR,
                NLOHMANN_JSON_VERSION_PATCH),
         ""},
        {"OpenSSL", OPENSSL_VERSION_STR, OpenSSL_version(OPENSSL_VERSION_STRING)},
        {"prometheus-cpp", CLERESTORY_PROMETHEUS_VERSION, ""},
        {"spdlog", dotted(SPDLOG_VER_MAJOR, SPDLOG_VER_MINOR, SPDLOG_VER_PATCH), ""},
        {"xxHash", dotted(XXH_VERSION_MAJOR, XXH_VERSION_MINOR, XXH_VERSION_RELEASE), ""},
        {"zlib", ZLIB_VERSION, zlibVersion()},
        {"zstd", ZSTD_VERSION_STRING, ZSTD_versionString()}};
}

std::string versionReport() {
    std::string text = "clerestory " + versionText() + " build " + buildId();
    for (const LibraryVersion& library : libraryVersions()) {
        const bool same = library.runs.empty() || library.runs == library.built;
        text += "\n  " + library.name + " " + (library.runs.empty() ? library.built : library.runs);
        if (!same) text += " (built with " + library.built + ")";
    }
    text += "\n  OpenGL " + openglVersion();
    return text + "\nknown vulnerabilities of these libraries and their mitigation: SECURITY.md";
}

}  // namespace clerestory
