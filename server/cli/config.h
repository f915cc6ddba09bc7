// The command line, parsed and checked; and the report of `--version`.
#pragma once

#include "server/config.h"

#include "reference/reference.h"

#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace clerestory {

// `clerestory render`, `plan`, `reference`, `compare` and `sequence`: without a server.
struct FrameCommand {
    std::string scene;        // id of a built-in scene, or a file
    std::string requestFile;  // "-": standard input; empty: {}
    // Values of flags by the path of the field; they override the file.
    std::multimap<std::string, std::string> fields;
    std::string output;  // a file whose extension selects the format; for sequence: a folder
    bool planAsJson = false;
};

// `clerestory reference` and `compare`: the path-traced reference.
struct ReferenceCommand {
    ReferenceMode mode = ReferenceMode::full;
    std::uint32_t samples = 64;
    std::uint64_t seed = 1;
    std::uint32_t threads = 0;  // 0: one for each processor
};

// Options of `clerestory compare`.
struct CompareCommand {
    std::string settings;       // presets separated by commas, or a JSON list; empty: every preset
    std::uint32_t frames = 15;  // measured after warm-up, for each setting
    std::string report;         // a JSON file; empty: none
    std::string pictures;       // a folder for error images; empty: none
};

// `clerestory sign`: a link that is valid for a limited time.
struct SignCommand {
    std::string link;
    std::string keyFile;
    std::int64_t validSeconds = 24 * 3600;
};

enum class Command { serve, render, plan, reference, compare, compile, sequence, scenes, devices, sign };

struct CommandLine {
    Command command = Command::serve;
    Config config;
    FrameCommand frame;
    ReferenceCommand reference;
    CompareCommand compare;
    SignCommand sign;
    std::vector<std::string> compileScenes;  // of `clerestory compile`; empty: all built-in scenes
};

// Returns the exit code if the program is done: help was printed, or an error message.
std::optional<int> parseCommandLine(int argc, char** argv, CommandLine& line);

// Flags of `clerestory serve` for limits, access, scenes and the renderer process.
void addLimitFlags(CLI::App& serve, Config& config);
void addAccessFlags(CLI::App& serve, Config& config);
// Scenes: uploads, memory.
void addSceneFlags(CLI::App& serve, Config& config);
void addWorkerFlags(CLI::App& serve, Config& config);

// A third-party library.
struct LibraryVersion {
    std::string name;
    std::string built;  // version at compile time
    std::string runs;   // version at run time; empty if it is linked statically or unknown
};

std::vector<LibraryVersion> libraryVersions();

// "clerestory 0.1.0 build ..." and a line for each library.
std::string versionReport();

}  // namespace clerestory
