// `bench_accuracy [--short] [--size WxH] [--samples N] [--output FOLDER] [SCENE...]`: error and
// milliseconds of every setting, on every scene, for every effect. Writes accuracy.csv,
// accuracy_hull.csv, accuracy_settings.csv, accuracy.md and one diagram per effect. `--with CSV`
// adds earlier measurements.
//
// `--short`: the presets on small images of the built-in scenes. With `--against FILE` no error may
// exceed 1.05 times the recorded one; `--record FILE` writes that file. Times are reported, not
// asserted.
#include "accuracy_measure.h"
#include "accuracy_record.h"
#include "accuracy_report.h"
#include "accuracy_rows.h"
#include "command_line.h"
#include "program.h"
#include "statistics.h"

#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>

namespace clerestory::bench {
namespace {

struct Options {
    bool brief = false, presetsOnly = false;
    std::string size, output, shared, record, against;
    std::uint32_t samples = 0;
    int rounds = 0;
    std::vector<std::string> scenes, with;
    Clock clock = Clock::wall;
};

std::string readFile(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw std::runtime_error("cannot read " + path);
    std::ostringstream content;
    content << file.rdbuf();
    return content.str();
}

void writeFile(const std::filesystem::path& path, const std::string& content) {
    std::ofstream file(path, std::ios::binary);
    file << content;
    file.close();
    if (!file) throw std::runtime_error("cannot write " + path.string());
}

MeasureOptions measureOptions(const Options& options) {
    MeasureOptions m;
    if (options.brief) {
        m = {.width = 128, .height = 72, .samples = 128, .rounds = 1, .framesPerRound = 2};
    }
    if (!options.size.empty() &&
        std::sscanf(options.size.c_str(), "%ux%u", &m.width, &m.height) != 2) {
        throw std::runtime_error("a size is written WIDTHxHEIGHT, not " + options.size);
    }
    if (options.samples != 0) m.samples = options.samples;
    if (options.rounds > 0) m.rounds = options.rounds;
    return m;
}

std::vector<AccuracyScene> scenesOf(const Options& options) {
    const std::vector<AccuracyScene> known =
        options.brief ? builtinAccuracyScenes() : allAccuracyScenes(options.shared);
    if (options.scenes.empty() && options.with.empty()) return known;
    std::vector<AccuracyScene> chosen;
    for (const std::string& argument : options.scenes) {
        AccuracyScene scene{
            std::filesystem::path(argument.substr(0, argument.rfind('@'))).stem().string(),
            argument,
            {}};
        for (const AccuracyScene& k : known) {
            if (k.name == argument) scene = k;
        }
        chosen.push_back(std::move(scene));
    }
    return chosen;
}

// Reports progress per scene on standard error, because the run takes minutes.
void tell(const AccuracyScene& scene, const Measured& measured, double milliseconds) {
    std::fprintf(stderr, "%s: %zu rows, truth %.1f s, all %.1f s, load average %.1f\n",
                 scene.name.c_str(), measured.points.size(), 1e-3 * measured.truthMs,
                 1e-3 * milliseconds, loadAverage());
}

void writeReports(const std::filesystem::path& folder, const Points& points, Clock clock) {
    std::filesystem::create_directories(folder);
    writeFile(folder / "accuracy.csv", csvOf(points));
    writeFile(folder / "accuracy_hull.csv", hullCsvOf(points, clock));
    writeFile(folder / "accuracy_settings.csv", settingsCsvOf(points, clock));
    writeFile(folder / "accuracy.md", markdownOf(points, clock));
    for (const Effect effect : kCurveEffects) {
        const std::string svg = svgOf(points, effect, clock);
        if (!svg.empty()) writeFile(folder / ("accuracy-" + curveName(effect) + ".svg"), svg);
    }
}

// Exit status: 1 when an error has grown.
int hold(const std::string& file, const Points& points, const std::string& renderer) {
    const Held result = heldAgainst(readFile(file), points);
    std::printf("%d errors compared with the record, %d not in it\n", result.held, result.missing);
    for (const std::string& line : result.exceeded) std::printf("grew: %s\n", line.c_str());
    if (renderer.find("llvmpipe") == std::string::npos) {
        std::printf("not llvmpipe but %s: reported only\n", renderer.c_str());
        return 0;
    }
    return result.exceeded.empty() ? 0 : 1;
}

int run(int argc, char** argv) {
    CommandLine line("What accuracy costs in time");
    Options options;
    line.addList("scenes", options.scenes, "names of the sweep, built-in ids or files");
    line.addFlag("--short", options.brief, "the presets, small, on the built-in scenes");
    line.addFlag("--presets", options.presetsOnly, "the presets alone");
    line.add("--size", options.size, "WIDTHxHEIGHT");
    line.add("--samples", options.samples, "paths a pixel of the truth");
    line.add("--rounds", options.rounds, "turns of each setting, five warm frames in each");
    line.add("--output", options.output, "folder of the CSV, the table and the pictures");
    line.add("--shared", options.shared, "folder of third-party scenes");
    line.addList("--with", options.with,
                 "CSV measured before, to be joined; no scene is measured that is not named");
    std::string clock = "wall";
    line.add("--clock", clock, "wall, or processor: time of all threads", {"wall", "processor"});
    line.add("--record", options.record, "write the errors to this file");
    line.add("--against", options.against, "hold the errors against this file");
    if (const auto status = line.parse(argc, argv)) return *status;
    if (clock == "processor") options.clock = Clock::processor;

    const MeasureOptions measuring = measureOptions(options);
    const std::vector<Accuracy> settings =
        options.brief || options.presetsOnly ? presets() : sweep();
    Points points;
    for (const std::string& file : options.with) {
        const Points before = pointsFrom(readFile(file));
        points.insert(points.end(), before.begin(), before.end());
    }
    std::string renderer;
    for (const AccuracyScene& scene : scenesOf(options)) {
        const Stopwatch watch;
        const Measured measured = measureAccuracy(scene, settings, measuring);
        points.insert(points.end(), measured.points.begin(), measured.points.end());
        renderer = measured.renderer;
        tell(scene, measured, watch.milliseconds());
        if (!options.output.empty()) writeReports(options.output, points, options.clock);
    }
    if (!options.output.empty()) writeReports(options.output, points, options.clock);
    if (!renderer.empty()) {
        std::printf("%s; %ux%u, %u paths a pixel of the truth\n\n", renderer.c_str(),
                    measuring.width, measuring.height, measuring.samples);
    }
    std::printf("%s\n", markdownOf(points, options.clock).c_str());
    if (!options.record.empty()) writeFile(options.record, recordOf(points, renderer));
    return options.against.empty() ? 0 : hold(options.against, points, renderer);
}

}  // namespace
}  // namespace clerestory::bench

int main(int argc, char** argv) {
    return clerestory::bench::runProgram("bench_accuracy", clerestory::bench::run, argc, argv);
}
