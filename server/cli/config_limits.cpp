#include "server/cli/config_limits.h"

#include <CLI/CLI.hpp>

namespace clerestory {
namespace {

void addCount(CLI::App& serve, const char* flag, std::size_t& value, double least, double most,
              const char* words) {
    serve.add_option(flag, value, words)
        ->check(CLI::Range(least, most).description(""))
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

}  // namespace

void addLimitFlags(CLI::App& serve, Config& config) {
    HttpLimits& limits = config.http.limits;
    addCount(serve, "--queue", config.queue, 1, 4096, "frames that may wait");
    serve
        .add_option("--queue-seconds", config.queueSeconds,
                    "predicted seconds of work that may wait; one frame always may")
        ->check(CLI::Range(0.01, 3600.0).description(""))
        ->type_name("SECONDS")
        ->group("Limits")
        ->capture_default_str();
    serve.add_option("--deadline", config.deadlineSeconds, "from request to answer")
        ->check(CLI::Range(0.001, 3600.0).description(""))
        ->type_name("SECONDS")
        ->group("Limits")
        ->capture_default_str();
    addCount(serve, "--max-work", config.renderer.mostSamples, 0, 1e15,
             "samples that one frame may shade: pixels x samples over all its passes; 0: any");
    addCount(serve, "--threads", config.http.threads, 4, 4096,
             "requests answered at once, beside those that wait for a frame");
    addCount(serve, "--connections", limits.connections, 8, 1e5,
             "open at once; above it the idlest gives way");
    addCount(serve, "--max-line", limits.requestLine, 64, 65536, "bytes of a request line");
    addCount(serve, "--max-path", limits.path, 32, 4096, "bytes of a path in it");
    addCount(serve, "--max-head", limits.headBytes, 256, 1 << 20,
             "bytes of request line and headers");
    addCount(serve, "--max-headers", limits.headers, 4, 1024, "headers of a request");
    addCount(serve, "--max-body", limits.bodyBytes, 1024, 64 * 1024, "bytes of a request's body");
    addCount(serve, "--max-sequence", config.sequenceBytes, 1024, 64 << 20,
             "bytes of a sequence's body");
    addSeconds(serve, "--head-seconds", limits.head, "for a request's head to come");
    addSeconds(serve, "--body-seconds", limits.body, "for its body to come");
    addSeconds(serve, "--write-seconds", limits.write,
               "for the next 4 KB of an answer to be taken");
    addSeconds(serve, "--idle-seconds", limits.idle, "between requests of a connection");
}

void addAccessFlags(CLI::App& serve, Config& config) {
    AccessOptions& access = config.http.access;
    const auto file = [&](const char* flag, std::string& value, const char* words) {
        serve.add_option(flag, value, words)->type_name("FILE")->group("Access");
    };
    serve
        .add_option("--allow-host", access.hosts,
                    "a host name that the server goes by, beside localhost and any address; may be "
                    "repeated; * is any")
        ->type_name("NAME")
        ->group("Access")
        ->take_all()
        ->allow_extra_args(false);
    file("--token-file", access.tokenFile,
         "asks for Authorization: Bearer with the first line of this file");
    file("--link-key-file", access.linkKeyFile,
         "asks that links to frames are signed (clerestory sign) with the first line of this file");
    serve
        .add_option("--client-header", access.clientHeader,
                    "a header in which a proxy in front names its client; its last name counts")
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
          "of loaded scenes; above it those that nobody uses are let go until they are asked for");
    serve
        .add_option("--uploads", uploads.folder,
                    "allows clients to POST scenes, and keeps them in this folder")
        ->type_name("DIR")
        ->group(group);
    bytes("--max-upload", uploads.limits.fileBytes, "of one upload, and of one file packed in it");
    bytes("--upload-space", uploads.limits.keptBytes, "of all uploads that are kept");
    const auto number = [&](const char* flag, auto& value, double most, const char* words) {
        serve.add_option(flag, value, words)
            ->check(CLI::Range(1.0, most).description(""))
            ->type_name("N")
            ->group(group)
            ->capture_default_str();
    };
    number("--upload-count", uploads.limits.count, 1e6, "uploads that are kept");
    number("--upload-files", import.maxFiles, 1e6, "files packed in one upload");
    number("--upload-triangles", import.maxTriangles, 1e9, "triangles of an uploaded scene");
    bytes("--upload-memory", import.addressSpaceBytes, "of address space while one is read");
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
    seconds("--upload-cpu", import.cpu, "of processor time for reading one");
    seconds("--upload-seconds", import.wallClock, "for reading one");
}

void addWorkerFlags(CLI::App& serve, Config& config) {
    const char* group = "Renderer process";
    serve
        .add_flag_callback(
            "--single-process", [&config] { config.singleProcess = true; },
            "render in the server's own process, for debuggers")
        ->group(group);
    serve
        .add_flag_callback(
            "--no-standby", [&config] { config.workers.standby = false; },
            "keep no second renderer warm: less memory, a slower restart")
        ->group(group);
    static const std::map<std::string, bool> kCompilations = {{"fast", true}, {"optimized", false}};
    serve
        .add_option("--first-compile", config.fastStart,
                    "fast: while no shaders are cached, the first renderer compiles without "
                    "optimising, until the standby has compiled them optimised; or optimized")
        ->transform(CLI::CheckedTransformer(kCompilations).description(""))
        ->type_name("KIND")
        ->group(group);
    serve
        .add_option("--worker-memory", config.workerMemoryBytes,
                    "bytes of address space of a renderer; 0: any")
        ->transform(CLI::AsSizeValue(false).description(""))
        ->type_name("BYTES")
        ->group(group)
        ->capture_default_str();
    serve.add_option("--hang", config.hangSeconds, "seconds on one frame that end a renderer")
        ->check(CLI::Range(1.0, 86400.0).description(""))
        ->type_name("SECONDS")
        ->group(group)
        ->capture_default_str();
}

}  // namespace clerestory
