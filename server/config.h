// The command line -> what to do, checked at start.
#pragma once

#include "server/http_server.h"
#include "server/scene_library.h"

#include <optional>

namespace clerestory {

struct Config {
    RendererOptions renderer;
    HttpOptions http;
    SceneSources scenes;
    std::size_t queue = 64;         // frames that may wait
    double deadlineSeconds = 10.0;  // from a request's arrival to its answer
    std::string logLevel = "info";
};

// `clerestory render` and `clerestory plan`: one frame without a server.
struct FrameCommand {
    std::string scene;        // id of a built-in scene, or a file
    std::string requestFile;  // "-": standard input; empty: {}
    // What flags say, by the field's path; they win over the file.
    std::multimap<std::string, std::string> fields;
    std::string output;  // its extension tells the format
    bool planAsJson = false;
};

enum class Command { serve, render, plan, scenes };

struct CommandLine {
    Command command = Command::serve;
    Config config;
    FrameCommand frame;
};

// Nothing to do any more (help was shown, or the line was wrong and one line said so): the exit
// code.
std::optional<int> parseCommandLine(int argc, char** argv, CommandLine& line);

}  // namespace clerestory
