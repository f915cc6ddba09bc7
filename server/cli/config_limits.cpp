#include "server/cli/config.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cctype>

namespace clerestory {
namespace {

void addCount(CLI::App& serve, const char* flag, std::size_t& value, double min, double max,
              const char* description) {
    serve.add_option(flag, value, description)
        ->check(CLI::Range(min, max).description(""))
        ->type_name("N")
        ->group("Limits")
        ->capture_default_str();
}

void addSeconds(CLI::App& serve, const char* flag, std::chrono::milliseconds& value,
                const char* words) {
    const double now = std::chrono::duration<double>(value).count();
    serve
        .add_option_function<double>(
            flag,
            [&value](const double& seconds) {
                value = std::chrono::round<std::chrono::milliseconds>(
                    std::chrono::duration<double>(seconds));
            },
            words)
        ->check(CLI::Range(0.01, 3600.0).description(""))
        ->type_name("SECONDS")
        ->group("Limits")
        ->default_str(std::to_string(static_cast<int>(now)));
}

// Browsers send an origin without a path, in lower case.
std::string originProblem(const std::string& origin) {
    const std::size_t scheme = origin.find("://");
    const bool plain = scheme != std::string::npos && scheme > 0 && scheme + 3 < origin.size() &&
                       origin.find('/', scheme + 3) == std::string::npos &&
                       std::none_of(origin.begin(), origin.end(), [](unsigned char c) {
                           return c <= ' ' || std::isupper(c) || c == ',' || c == 127;
                       });
    return plain || origin == "*"
               ? ""
               : "must be SCHEME://HOST or SCHEME://HOST:PORT in lower case, or *";
}

}  // namespace

void addLimitFlags(CLI::App& serve, Config& config) {
    HttpLimits& limits = config.http.limits;
    addCount(serve, "--queue", config.queue, 1, 4096, "maximum number of queued frames");
    serve
        .add_option(
            "--queue-seconds", config.queueSeconds,
            "maximum predicted time of queued frames; one frame of each client may always wait")
        ->check(CLI::Range(0.01, 3600.0).description(""))
        ->type_name("SECONDS")
        ->group("Limits")
        ->capture_default_str();
    serve.add_option("--deadline", config.deadlineSeconds, "from request to response")
        ->check(CLI::Range(0.001, 3600.0).description(""))
        ->type_name("SECONDS")
        ->group("Limits")
        ->capture_default_str();
    serve
        .add_option("--frame-cache", config.frameCacheBytes,
                    "memory of recently drawn frames, which answer equal requests; 0: none")
        ->transform(CLI::AsSizeValue(false).description(""))
        ->type_name("BYTES")
        ->group("Limits")
        ->capture_default_str();
    addCount(serve, "--max-work", config.renderer.maxShadedSamples, 0, 1e15,
             "samples that one frame may shade: pixels x samples over all passes; 0: no limit");
    addCount(serve, "--threads", config.http.threads, 4, 4096,
             "concurrent request handlers, besides those that wait for a frame or stream");
    addCount(serve, "--connections", limits.connections, 8, 1e5,
             "open connections; above it an idle one of the client with the most is closed");
    addCount(serve, "--max-line", limits.requestLine, 64, 65536, "bytes of a request line");
    addCount(serve, "--max-path", limits.path, 32, 4096, "bytes of the path");
    addCount(serve, "--max-head", limits.headBytes, 256, 1 << 20,
             "bytes of request line and headers");
    addCount(serve, "--max-headers", limits.headers, 4, 1024, "number of headers of a request");
    addCount(serve, "--max-body", limits.bodyBytes, 1024, 64 * 1024, "bytes of a request body");
    addCount(serve, "--max-sequence", config.sequenceBytes, 1024, 64 << 20,
             "bytes of the body of a sequence request");
    addSeconds(serve, "--head-seconds", limits.head, "to receive request line and headers");
    addSeconds(serve, "--body-seconds", limits.body, "to receive the body");
    addSeconds(serve, "--write-seconds", limits.write, "for the client to read 4 KB of a response");
    addSeconds(serve, "--idle-seconds", limits.idle, "between requests of a connection");
}

void addAccessFlags(CLI::App& serve, Config& config) {
    AccessOptions& access = config.http.access;
    const auto file = [&](const char* flag, std::string& value, const char* words) {
        serve.add_option(flag, value, words)->type_name("FILE")->group("Access");
    };
    serve
        .add_option(
            "--allow-host", access.hosts,
            "allowed host name, besides localhost and IP addresses; may be repeated; * allows "
            "any")
        ->type_name("NAME")
        ->group("Access")
        ->take_all()
        ->allow_extra_args(false);
    serve
        .add_option("--allow-origin", access.origins,
                    "origin whose pages may read answers (CORS), such as https://shop.example; may "
                    "be repeated; * allows any")
        ->check([](const std::string& origin) { return originProblem(origin); })
        ->type_name("ORIGIN")
        ->group("Access")
        ->take_all()
        ->allow_extra_args(false);
    file("--token-file", access.tokenFile,
         "requires Authorization: Bearer with the first line of this file");
    file(
        "--link-key-file", access.linkKeyFile,
        "requires links to frames to be signed (clerestory sign) with the first line of this file");
    serve
        .add_option("--client-header", access.clientHeader,
                    "header in which a reverse proxy names its client; the last name counts")
        ->type_name("NAME")
        ->group("Access");
}

void addSceneFlags(CLI::App& serve, Config& config) {
    UploadOptions& uploads = config.scenes.uploads;
    ImportLimits& import = uploads.import;
    const char* group = "Scenes";
    const auto bytes = [&](const char* flag, auto& value, const char* words) {
        serve.add_option(flag, value, words)
            ->transform(CLI::AsSizeValue(false).description(""))
            ->type_name("BYTES")
            ->group(group)
            ->capture_default_str();
    };
    bytes("--scene-memory", config.scenes.memoryBytes,
          "memory of loaded scenes; beyond it the least recently used ones are unloaded");
    serve
        .add_option(
            "--uploads", uploads.folder,
            "allows clients to upload scenes and environment maps, which are stored in this folder")
        ->type_name("DIR")
        ->group(group);
    bytes("--max-upload", uploads.limits.fileBytes,
          "size of an upload, and of a file in an archive");
    bytes("--upload-space", uploads.limits.keptBytes, "size of all stored uploads");
    const auto number = [&](const char* flag, auto& value, double max, const char* words) {
        serve.add_option(flag, value, words)
            ->check(CLI::Range(1.0, max).description(""))
            ->type_name("N")
            ->group(group)
            ->capture_default_str();
    };
    number("--upload-count", uploads.limits.count, 1e6, "number of stored uploads");
    number("--upload-files", import.maxFiles, 1e6, "files in an uploaded archive");
    number("--upload-triangles", import.maxTriangles, 1e9,
           "triangles, lines and points of an uploaded scene, of all its instances");
    bytes("--upload-memory", import.addressSpaceBytes, "address space of the import");
    const auto seconds = [&](const char* flag, auto& value, const char* words) {
        using Duration = std::remove_reference_t<decltype(value)>;
        serve
            .add_option_function<unsigned>(
                flag, [&value](const unsigned& n) { value = Duration(std::chrono::seconds(n)); },
                words)
            ->check(CLI::Range(1, 3600).description(""))
            ->type_name("SECONDS")
            ->group(group)
            ->default_str(
                std::to_string(std::chrono::duration_cast<std::chrono::seconds>(value).count()));
    };
    seconds("--upload-cpu", import.cpu, "processor time of the import");
    seconds("--upload-seconds", import.wallClock, "duration of the import");
}

void addWorkerFlags(CLI::App& serve, Config& config) {
    const char* group = "Renderer process";
    serve
        .add_flag_callback(
            "--single-process", [&config] { config.singleProcess = true; },
            "render in the process of the server, for debugging")
        ->group(group);
    serve
        .add_flag_callback(
            "--no-standby", [&config] { config.workers.standby = false; },
            "no standby renderer: less memory, slower restart")
        ->group(group);
    serve
        .add_option("--renderers", config.workers.renderers,
                    "renderers that draw different frames at the same time; they share the "
                    "processors, and each holds its own scenes")
        ->check(CLI::Range(1, 8).description(""))
        ->excludes("--single-process")
        ->type_name("N")
        ->group(group)
        ->capture_default_str();
    static const std::map<std::string, bool> kCompilations = {{"fast", true}, {"optimized", false}};
    serve
        .add_option(
            "--first-compile", config.fastStart,
            "fast: without cached shaders the first renderer compiles without optimisation, "
            "until the standby has compiled optimised ones; or optimized")
        ->transform(CLI::CheckedTransformer(kCompilations).description(""))
        ->type_name("KIND")
        ->group(group);
    serve
        .add_option("--worker-memory", config.workerMemoryBytes,
                    "address space of a renderer process; 0: no limit")
        ->transform(CLI::AsSizeValue(false).description(""))
        ->type_name("BYTES")
        ->group(group)
        ->capture_default_str();
    serve
        .add_option("--hang", config.hangSeconds,
                    "a renderer that needs longer for one frame is restarted")
        ->check(CLI::Range(1.0, 86400.0).description(""))
        ->type_name("SECONDS")
        ->group(group)
        ->capture_default_str();
}

}  // namespace clerestory
