// First use: times from the start of a process, with empty caches and with those that the first run
// filled.
#pragma once

#include "child_process.h"

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace clerestory::bench {

// Folders of one's own for all caches. The shader caches of Mesa and those of the program lie below
// the same folder, so that both are counted and emptied.
class CacheFolders {
public:
    CacheFolders();
    ~CacheFolders();
    CacheFolders(const CacheFolders&) = delete;
    CacheFolders& operator=(const CacheFolders&) = delete;

    void clear() const;
    Environment environment() const;
    std::filesystem::path file(const std::string& name) const { return folder_ / name; }

    struct Content {
        std::size_t entries = 0, files = 0, bytes = 0;
    };
    Content shaders() const;

private:
    std::filesystem::path folder_;
};

struct Subject {
    std::string name;      // in the table
    std::string argument;  // a built-in scene or a file
};

struct ServerStart {
    std::optional<double> firstFrame;  // seconds from process start to the first 200
    double processorSeconds = 0.0;     // of server and renderers until then
    std::map<int, int> before, after;  // answers other than 200, by status; 0: none came
    double secondFrameMs = 0.0, tenthFrameMs = 0.0;
    std::string renderer;         // body of /v1/renderer
    CacheFolders::Content cache;  // after the server's end
};
// `clerestory serve --scene X` and ten frames of the default view, one after the other.
ServerStart measureFrames(const std::string& program, const std::vector<std::string>& flags,
                          const Subject& subject, const CacheFolders& folders);
// The same server, polled only with /readyz, for which the server draws its own frame.
// Seconds from process start to its first 200.
std::optional<double> measureReadiness(const std::string& program,
                                       const std::vector<std::string>& flags,
                                       const Subject& subject, const CacheFolders& folders);

struct Run {
    bool ended = false;  // with exit status 0
    double wallSeconds = 0.0, processorSeconds = 0.0;
    CacheFolders::Content cache;
};
// `clerestory render X` of 320 x 180, with further flags.
Run measureRender(const std::string& program, const std::vector<std::string>& flags,
                  const Subject& subject, const CacheFolders& folders);

struct ColdOptions {
    std::string program;
    std::vector<std::string> flags;   // of serve
    std::vector<std::string> scenes;  // ids, names of shared scenes, files; none: the usual ones
    std::filesystem::path shared;     // folder of the shared scenes
    int runs = 1;
};
// Prints Markdown tables. Exit status.
int runCold(const ColdOptions& options);

}  // namespace clerestory::bench
