// Formats the rows of `bench_start --cold`.
#include "tests/bench/cold_start.h"

#include "statistics.h"

#include <sys/wait.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <functional>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace clerestory::bench {
namespace {

namespace fs = std::filesystem;

const char* const kShared[] = {"TransmissionTest", "Sponza", "Duck", "FlightHelmet", "CornellBox"};

template <class T>
struct Pair {
    std::vector<T> cold, filled;  // one a run
};

std::string number(double value, int digits) {
    char text[32];
    std::snprintf(text, sizeof text, "%.*f", digits, value);
    return text;
}

// The median of the runs, cold and filled.
template <class T>
std::string both(const Pair<T>& runs, int digits,
                 const std::function<std::optional<double>(const T&)>& value) {
    const auto one = [&](const std::vector<T>& list) -> std::string {
        std::vector<double> values;
        for (const T& run : list) {
            const auto known = value(run);
            if (!known) return "**none**";
            values.push_back(*known);
        }
        return number(median(values), digits);
    };
    return one(runs.cold) + " / " + one(runs.filled);
}

// A summary of all runs: "409 x 3, **504 x 2**".
std::string answers(const std::map<int, int>& counts) {
    std::string text;
    for (const auto& [status, count] : counts) {
        const std::string one =
            (status == 0 ? "no answer" : std::to_string(status)) + " x " + std::to_string(count);
        const bool expected = status == 409 || status == 503;
        text += (text.empty() ? "" : ", ") + (expected ? one : "**" + one + "**");
    }
    return text.empty() ? "0" : text;
}

std::string answers(const std::vector<ServerStart>& runs) {
    std::map<int, int> before, after;
    for (const ServerStart& run : runs) {
        for (const auto& [status, count] : run.before) before[status] += count;
        for (const auto& [status, count] : run.after) after[status] += count;
    }
    return answers(before) + (after.empty() ? "" : ", then " + answers(after));
}

int overDeadline(const Pair<ServerStart>& runs) {
    int sum = 0;
    for (const auto* list : {&runs.cold, &runs.filled}) {
        for (const ServerStart& run : *list) {
            for (const auto* counts : {&run.before, &run.after}) {
                const auto found = counts->find(504);
                sum += found == counts->end() ? 0 : found->second;
            }
        }
    }
    return sum;
}

template <class T>
std::string cacheText(const Pair<T>& runs) {
    const CacheFolders::Content& last = runs.cold.back().cache;
    return std::to_string(last.entries) + " in " + std::to_string(last.files) + " files, " +
           number(1e-6 * static_cast<double>(last.bytes), 1) + " MB";
}

std::string textOf(const fs::path& file) {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
}

std::string processorModel() {
    std::istringstream lines(textOf("/proc/cpuinfo"));
    for (std::string line; std::getline(lines, line);) {
        if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
    }
    return "processor unknown";
}

// The scenes that `clerestory scenes` lists.
std::vector<std::string> builtins(const std::string& program, const CacheFolders& folders) {
    const std::string list = folders.file("scenes");
    if (awaitEnd(startProgram({program, "scenes"}, {}, list)).status != 0) {
        throw std::runtime_error(program + " scenes failed: " + textOf(list));
    }
    std::vector<std::string> ids;
    std::istringstream lines(textOf(list));
    for (std::string line; std::getline(lines, line);)
        ids.push_back(line.substr(0, line.find(' ')));
    return ids;
}

std::optional<Subject> sharedScene(const fs::path& shared, const std::string& name) {
    for (const char* ending : {".gltf", ".glb"}) {
        const fs::path file = shared / name / (name + ending);
        if (fs::is_regular_file(file)) return Subject{name, file};
    }
    return std::nullopt;
}

std::vector<Subject> subjects(const ColdOptions& options, const std::vector<std::string>& own) {
    std::vector<Subject> list;
    const auto isOwn = [&](const std::string& name) {
        return std::find(own.begin(), own.end(), name) != own.end();
    };
    for (const std::string& name : options.scenes) {
        if (isOwn(name)) {
            list.push_back({name, name});
        } else if (const auto shared = sharedScene(options.shared, name)) {
            list.push_back(*shared);
        } else if (fs::is_regular_file(name)) {
            list.push_back({fs::path(name).stem(), name});
        } else {
            const std::string folder = options.shared.string();
            throw std::runtime_error("--scenes " + name + ": no built-in scene, no file" +
                                     (folder.empty() ? ""
                                                     : ", and no folder of " + folder +
                                                           " with a .gltf or .glb of its name"));
        }
    }
    if (!options.scenes.empty()) return list;
    for (const std::string& name : own) list.push_back({name, name});
    if (!fs::is_directory(options.shared)) {
        std::fprintf(stderr, "shared scenes skipped: no folder %s\n", options.shared.c_str());
        return list;
    }
    for (const char* name : kShared) {
        if (const auto shared = sharedScene(options.shared, name)) {
            list.push_back(*shared);
        } else {
            std::fprintf(stderr, "%s skipped: not in %s\n", name, options.shared.c_str());
        }
    }
    return list;
}

// Each run begins with empty folders; its second half finds what the first left.
template <class T>
Pair<T> coldAndFilled(const char* what, const Subject& subject, const ColdOptions& options,
                      const CacheFolders& folders, const std::function<T()>& measure) {
    Pair<T> runs;
    for (int run = 0; run < options.runs; ++run) {
        std::fprintf(stderr, "%s: %s, run %d of %d\n", what, subject.name.c_str(), run + 1,
                     options.runs);
        folders.clear();
        runs.cold.push_back(measure());
        runs.filled.push_back(measure());
    }
    return runs;
}

// Returns /v1/renderer.
std::string serverTable(const std::vector<Subject>& list, const ColdOptions& options,
                        const CacheFolders& folders) {
    std::printf(
        "\n`clerestory serve --scene X`, default view, 1280x720, standard. Pairs are: caches empty "
        "/ filled.\n\n"
        "| Scene | First frame, s | CPU until then, s | Answers before it | Second frame, ms | "
        "Tenth frame, ms | /readyz 200, s | Shader cache |\n"
        "|---|---|---|---|---|---|---|---|\n");
    std::string renderer;
    int late = 0;
    for (const Subject& subject : list) {
        const auto frames = coldAndFilled<ServerStart>(
            "frames of a server", subject, options, folders,
            [&] { return measureFrames(options.program, options.flags, subject, folders); });
        const auto ready = coldAndFilled<std::optional<double>>(
            "readiness of a server", subject, options, folders,
            [&] { return measureReadiness(options.program, options.flags, subject, folders); });
        const auto value = [&](int digits, auto member) {
            return both<ServerStart>(frames, digits, [&](const ServerStart& start) {
                const std::optional<double> known = start.*member;
                return start.firstFrame ? known : std::nullopt;
            });
        };
        const std::string readiness =
            both<std::optional<double>>(ready, 2, [](const auto& seconds) { return seconds; });
        std::printf("| %s | %s | %s | %s / %s | %s | %s | %s | %s |\n", subject.name.c_str(),
                    value(2, &ServerStart::firstFrame).c_str(),
                    value(1, &ServerStart::processorSeconds).c_str(), answers(frames.cold).c_str(),
                    answers(frames.filled).c_str(), value(0, &ServerStart::secondFrameMs).c_str(),
                    value(0, &ServerStart::tenthFrameMs).c_str(), readiness.c_str(),
                    cacheText(frames).c_str());
        std::fflush(stdout);
        late += overDeadline(frames);
        if (!frames.cold.back().renderer.empty()) renderer = frames.cold.back().renderer;
    }
    std::printf("\n%s\n", late == 0
                              ? "No answer was 504."
                              : ("**" + std::to_string(late) + " answers were 504.**").c_str());
    return renderer;
}

void renderTable(const std::vector<Subject>& list, const ColdOptions& options,
                 const CacheFolders& folders) {
    std::printf(
        "\n`clerestory render X`, 320x180, the whole process.\n\n"
        "| Scene | Wall, s | CPU, s | Shader cache |\n|---|---|---|---|\n");
    const auto row = [&](Subject subject, const std::vector<std::string>& flags) {
        const auto runs = coldAndFilled<Run>("render", subject, options, folders, [&] {
            const Run run = measureRender(options.program, flags, subject, folders);
            if (!run.ended) {
                std::fprintf(stderr, "%s", textOf(folders.file("log")).c_str());
            }
            return run;
        });
        const auto value = [&](int digits, double Run::*member) {
            return both<Run>(runs, digits, [&](const Run& run) {
                return run.ended ? std::optional(run.*member) : std::nullopt;
            });
        };
        std::printf("| %s | %s | %s | %s |\n", subject.name.c_str(),
                    value(2, &Run::wallSeconds).c_str(), value(1, &Run::processorSeconds).c_str(),
                    cacheText(runs).c_str());
        std::fflush(stdout);
    };
    for (const Subject& subject : list) {
        row(subject, {});
        if (subject.argument != "chapel") continue;
        row({"chapel, draft", "chapel"}, {"--accuracy", "draft"});
        row({"chapel, effects off", "chapel"}, {"--effects", "none"});
    }
}

std::string driver(const std::string& renderer) {
    const auto json = nlohmann::json::parse(renderer, nullptr, false);
    if (!json.is_object()) return "driver unknown";
    const auto program = json.value("program", nlohmann::json::object());
    return json.value("renderer", "renderer unknown") + ", " +
           json.value("version", "version unknown") + "; program " +
           program.value("version", "unknown") + ", build " + program.value("build", "unknown");
}

}  // namespace

int runCold(const ColdOptions& options) {
    const CacheFolders folders;
    const std::vector<Subject> list = subjects(options, builtins(options.program, folders));
    const double before = loadAverage();
    const std::string renderer = serverTable(list, options, folders);
    renderTable(list, options, folders);
    std::printf("\nMachine: %u processors, %s; load average %.1f before, %.1f after; %s.\n",
                std::thread::hardware_concurrency(), processorModel().c_str(), before,
                loadAverage(), driver(renderer).c_str());
    if (options.runs > 1) {
        std::printf("Medians of %d runs; answers are counted over all of them.\n", options.runs);
    }
    return 0;
}

}  // namespace clerestory::bench
