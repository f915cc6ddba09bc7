// `clerestory render`, `plan`, `scenes` and `devices`, and the input of all commands that run
// without a server.
#include "server/api/encode_answer.h"
#include "server/api/frame_json.h"
#include "server/cli/commands.h"
#include "server/jobs/jobs.h"
#include "server/scenes/compile_ahead.h"
#include "server/scenes/scene_entries.h"
#include "server/scenes/shader_cache.h"

#include "comparison/curve.h"
#include "gl/devices.h"

#include "scene/builtin/builtin_scenes.h"

#include <nlohmann/json.hpp>

#include <unistd.h>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <future>
#include <iostream>
#include <iterator>

namespace clerestory {
namespace {

std::string fileText(const std::string& file) {
    if (file == "-") {
        return {std::istreambuf_iterator<char>(std::cin), std::istreambuf_iterator<char>()};
    }
    std::ifstream stream(file, std::ios::binary);
    if (!stream) throw std::runtime_error("cannot read \"" + file + "\"");
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

std::optional<OutputFormat> formatOf(const std::filesystem::path& file) {
    const std::string extension = file.extension().string();
    if (extension == ".jpg" || extension == ".jpeg") return OutputFormat::jpeg;
    if (extension == ".png") return OutputFormat::png;
    if (extension == ".npy") return OutputFormat::npy;
    if (extension == ".exr") return OutputFormat::exr;
    if (extension == ".webp") return OutputFormat::webp;
    if (extension == ".json") return OutputFormat::json;
    return std::nullopt;
}

}  // namespace

Scene sceneFor(const CommandLine& line, const EnvironmentMaps& maps) {
    const std::string& source = line.frame.scene;
    if (auto scene = makeBuiltinScene(source)) return *std::move(scene);
    const auto [file, sceneOfFile] = sceneSource(source);
    if (!std::filesystem::exists(file)) {
        throw std::runtime_error("no scene \"" + source +
                                 "\": neither a built-in scene nor a file");
    }
    ImportOptions options = line.config.scenes.import;
    options.scene = sceneOfFile;
    Scene scene = importScene(file, options);
    if (!maps.contains(scene.environment)) lightWithSky(scene);
    for (const ImportWarning& w : scene.warnings) {
        std::cerr << "warning: " << (w.subject.empty() ? w.code : w.code + " '" + w.subject + "'")
                  << ": " << w.message << "\n";
    }
    return scene;
}

std::string requestText(const FrameCommand& command) {
    return command.requestFile.empty() ? "{}" : fileText(command.requestFile);
}

FrameRequest requestFor(const FrameCommand& command) {
    FrameRequest defaults;
    if (!command.output.empty()) {
        const auto format = formatOf(command.output);
        if (!format) {
            throw std::runtime_error(
                "the output must end in .jpg, .png, .webp, .npy, .exr or .json");
        }
        defaults.output.format = *format;
    }
    nlohmann::json body = strictJson(requestText(command));
    if (body.is_object()) body.merge_patch(bodyFromQuery(command.fields));
    return frameRequestFrom(body, defaults);
}

EnvironmentMaps environmentsOf(const CommandLine& line, FrameRequest& request) {
    EnvironmentMaps maps;
    for (const std::string& name : builtinEnvironmentNames()) {
        maps[name] = std::make_shared<const EnvironmentMap>(*builtinEnvironment(name));
    }
    for (const auto& source : line.config.scenes.environments) {
        auto map = std::make_shared<const EnvironmentMap>(loadEnvironment(source));
        if (!request.environment.map) request.environment.map = map->name;
        maps[map->name] = std::move(map);
    }
    return maps;
}

const EnvironmentMap& lightingOf(const EnvironmentMaps& maps, const Scene& scene,
                                 const FrameRequest& request) {
    const std::string name = request.environment.map.value_or(scene.environment);
    const auto found = maps.find(name);
    if (found == maps.end()) {
        throw std::runtime_error("there is no environment map \"" + name + "\"");
    }
    return *found->second;
}

void ProgressLine::show(double fraction) {
    const bool onTerminal = ::isatty(STDERR_FILENO) == 1;
    const int percent = static_cast<int>(100.0 * fraction);
    if (percent == shown_ || (!onTerminal && percent / 10 == shown_ / 10)) return;
    shown_ = percent;
    std::fprintf(stderr, onTerminal ? "\r%s %3d %%" : "%s %3d %%\n", work_, percent);
}

void ProgressLine::end() const {
    if (::isatty(STDERR_FILENO) == 1) std::fprintf(stderr, "\n");
}

namespace {

// A renderer with the scene, and the request for it.
struct Prepared {
    std::unique_ptr<Renderer> renderer;
    FrameRequest request;
    std::unique_ptr<CompileAhead> compileAhead;  // null unless for one frame
    std::string compiledMark;                    // see setCompiled()
};

// Measures the curve of this view, replaces the budget by the setting that meets it, and prints
// that to stderr.
void resolveBudget(Renderer& renderer, const Scene& scene, const EnvironmentMaps& maps,
                   FrameRequest& request) {
    ProgressLine progress("measuring");
    const EnvironmentMap& lighting = lightingOf(maps, scene, request);
    const auto curve = measureCurve(
        request,
        [&](const FrameRequest& frame, std::uint32_t samples) {
            return traceReference({.scene = scene,
                                   .frame = frame,
                                   .environment = lighting,
                                   .maps = maps,
                                   .samples = samples});
        },
        [&](const FrameRequest& frame) { return drawTimed(renderer, frame); },
        [&](double fraction) {
            progress.show(fraction);
            return true;
        });
    progress.end();
    const Chosen chosen = choose(*curve, request.accuracy);
    request.accuracy = curve->points[chosen.point].accuracy;
    std::cerr << chosen.words << "\n";
}

// `oneFrame`: shaders are compiled without optimisation, which would take longer than the frame.
Prepared prepare(const CommandLine& line, bool oneFrame = false) {
    Prepared p{.request = requestFor(line.frame)};
    oneFrame = oneFrame && !p.request.accuracy.isBudget() && !compiledBefore(line.frame.scene);
    if (oneFrame) compileFast();
    EnvironmentMaps maps;
    std::future<Scene> loading = std::async(std::launch::async, [&] {
        maps = environmentsOf(line, p.request);
        return sceneFor(line, maps);
    });
    RendererOptions options = line.config.renderer;
    options.fewPrograms = compilesFast();
    p.renderer = std::make_unique<Renderer>(options);
    Scene scene = loading.get();
    scene.id = p.request.scene = "scene";
    FrameRequest kind = p.request;  // frames that differ only in this use nearly the same programs
    kind.camera = {};
    kind.time = 0.0;
    kind.output = {};
    kind.width = kind.height = 1;
    p.compiledMark = "frame of " + std::to_string(scene.contentHash) + '\n' + canonicalText(kind);
    const bool isNew = oneFrame && !compiledBefore(p.compiledMark);
    if (isNew && CompileAhead::helps(p.renderer->identity())) {
        std::vector<std::shared_ptr<const EnvironmentMap>> list;
        for (const auto& [name, map] : maps) list.push_back(map);
        p.compileAhead = std::make_unique<CompileAhead>(options, copyWithoutTexels(scene),
                                                        std::move(list), std::vector{p.request});
    }
    for (const auto& [name, map] : maps) p.renderer->addEnvironment(map);
    if (p.request.accuracy.isBudget()) {
        p.renderer->addScene(scene);
        resolveBudget(*p.renderer, scene, maps, p.request);
        return p;
    }
    p.renderer->addScene(std::move(scene));
    p.renderer->expectCompilation(p.request.scene, isNew);
    return p;
}

}  // namespace

void requireLight(Renderer& renderer, const FrameRequest& request) {
    const LightState light = renderer.completeLight(request);
    if (!light.failure.empty()) {
        throw std::runtime_error("the light of surfaces could not be computed: " + light.failure);
    }
}

int runRender(const CommandLine& line) {
    Prepared p = prepare(line, true);
    requireLight(*p.renderer, p.request);
    const Frame frame = p.renderer->render(p.request);
    if (p.compileAhead) {
        p.compileAhead->stop();
        setCompiled(p.compiledMark);
    }
    const Bytes bytes = encoded(frame, p.request.output);
    std::ofstream file(line.frame.output, std::ios::binary);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!file) throw std::runtime_error("cannot write \"" + line.frame.output + "\"");
    return 0;
}

int runPlan(const CommandLine& line) {
    Prepared p = prepare(line);
    const FramePlan plan = p.renderer->plan(p.request);
    if (line.frame.planAsJson) {
        using nlohmann::ordered_json;
        std::cout << planJson(plan).dump(2, ' ', false, ordered_json::error_handler_t::replace)
                  << "\n";
    } else {
        std::cout << toText(plan);
    }
    return 0;
}

int runScenes() {
    for (const BuiltinScene& scene : builtinScenes()) {
        std::cout << scene.id << std::string(scene.id.size() < 18 ? 18 - scene.id.size() : 1, ' ')
                  << scene.title << "\n";
    }
    return 0;
}

int runDevices() {
    const std::vector<gl::Device> devices = gl::devices();
    if (devices.empty()) throw std::runtime_error("EGL lists no devices on this machine");
    for (std::size_t i = 0; i < devices.size(); ++i) {
        const gl::Device& device = devices[i];
        std::cout << i << "  "
                  << (device.renderer.empty() ? "no OpenGL 4.3 driver" : device.renderer)
                  << (device.software ? ", software" : "");
        if (device.cuda) std::cout << ", CUDA device " << *device.cuda;
        if (!device.file.empty()) std::cout << ", " << device.file;
        std::cout << "\n";
    }
    return 0;
}

}  // namespace clerestory
