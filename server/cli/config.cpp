#include "server/cli/config.h"

#include "server/jobs/budgets.h"
#include "server/scenes/cache_folder.h"

#include <CLI/CLI.hpp>

#include <iostream>

namespace clerestory {
namespace {

void addRendererFlags(CLI::App& command, Config& config) {
    static const std::map<std::string, Backend> kBackends = {{"auto", Backend::automatic},
                                                             {"software", Backend::software},
                                                             {"hardware", Backend::hardware}};
    static const std::map<std::string, Computation> kRays = {{"auto", Computation::automatic},
                                                             {"shader", Computation::shader},
                                                             {"cpu", Computation::processor}};
    command
        .add_option("--rays", config.renderer.rays,
                    "where rays of mirrors and glass are followed: auto, shader or cpu")
        ->transform(CLI::CheckedTransformer(kRays).description(""));
    command.add_option("--renderer", config.renderer.backend, "auto, software or hardware")
        ->transform(CLI::CheckedTransformer(kBackends).description(""))
        ->type_name("KIND");
    command
        .add_option("--device", config.renderer.device,
                    "index of an EGL device, as `clerestory devices` lists them; default: the "
                    "first with a driver, hardware before software")
        ->type_name("N");
    command
        .add_option("--environment", config.scenes.environments,
                    "an .hdr or .exr file, a .ktx, .ktx2 or .dds cube map, or a folder of six "
                    "images; may be repeated")
        ->type_name("FILE|DIR")
        ->take_all()
        ->allow_extra_args(false);
    command
        .add_option("--scene-cache", config.cache.folder,
                    "folder of imported scenes, for a fast restart; none disables it; default "
                    "$XDG_CACHE_HOME/clerestory or ~/.cache/clerestory")
        ->type_name("DIR");
    command
        .add_option(
            "--shader-cache", config.shaderCache,
            "folder of the driver's compiled shaders, shared by all renderer processes; none "
            "disables it; default $XDG_CACHE_HOME/clerestory/shaders or "
            "~/.cache/clerestory/shaders")
        ->type_name("DIR");
    command
        .add_option(
            "--scene-cache-size", config.cache.mostBytes,
            "maximum size of that folder; beyond it the least recently used scene is removed")
        ->transform(CLI::AsSizeValue(false).description(""))
        ->type_name("BYTES")
        ->capture_default_str();
}

void addServe(CLI::App& app, CommandLine& line) {
    Config& config = line.config;
    CLI::App* serve = app.add_subcommand("serve", "Serve frames over HTTP");
    config.singleProcess = false;
    config.renderer.maxShadedSamples = kMaxSamplesServed;
    serve->callback([&line] { line.command = Command::serve; });
    serve->add_option("--port", config.http.port, "port; 0 selects a free one")
        ->check(CLI::Range(0, 65535).description(""))
        ->type_name("N")
        ->capture_default_str();
    serve->add_option("--host", config.http.host, "address to listen on")
        ->type_name("ADDRESS")
        ->capture_default_str();
    serve
        ->add_option(
            "--scene", config.scenes.scenes,
            "a model file, also with a colon and the name or number of one of its scenes, or a "
            "built-in scene; may be repeated; the first is the default")
        ->type_name("FILE|ID")
        ->take_all()
        ->allow_extra_args(false);
    serve
        ->add_option("--scenes", config.scenes.folder,
                     "a folder of models; each is loaded when first requested")
        ->type_name("DIR");
    addRendererFlags(*serve, config);
    serve->add_option("--log-level", config.logLevel, "debug, info, warn, error or off")
        ->check(CLI::IsMember({"debug", "info", "warn", "error", "off"}).description(""))
        ->type_name("LEVEL")
        ->capture_default_str();
    addLimitFlags(*serve, config);
    addAccessFlags(*serve, config);
    addSceneFlags(*serve, config);
    addWorkerFlags(*serve, config);
}

// Flags of all frame commands: the scene, the request, and its common fields.
void addFrameFlags(CLI::App& command, CommandLine& line) {
    FrameCommand& frame = line.frame;
    command
        .add_option("scene", frame.scene,
                    "a model file, also with a colon and the name or number of one of its "
                    "scenes, or the id of a built-in scene")
        ->required()
        ->type_name("SCENE");
    command.add_option("--request", frame.requestFile, "a request as JSON; - reads standard input")
        ->type_name("FILE");
    const auto field = [&](const char* flag, const char* name, const char* words,
                           const char* type) {
        command
            .add_option_function<std::string>(
                flag, [&frame, name](const std::string& v) { frame.fields.emplace(name, v); },
                words)
            ->type_name(type);
    };
    field("--camera", "camera.name", "a camera of the scene", "NAME");
    field("--eye", "camera.position", "position of the eye in metres", "X,Y,Z");
    field("--target", "camera.target", "point to look at", "X,Y,Z");
    field("--up", "camera.up", "up direction", "X,Y,Z");
    field("--yfov", "camera.yfov", "vertical field of view in radians", "ANGLE");
    field("--time", "time", "seconds", "SECONDS");
    field("--clip", "clip", "animation to play", "NAME");
    field("--variant", "variant", "material variant of the scene", "NAME");
    field("--accuracy", "accuracy.preset", "draft, standard or fine", "PRESET");
    field("--channel", "output.channel",
          "color, depth, normal, position, albedo, objectId, materialId, through or instances; "
          "classId and flow need fields of --request",
          "NAME");
    field("--quality", "output.quality", "quality of JPEG and WebP, 1 to 100", "N");
    command
        .add_option_function<std::string>(
            "--size",
            [&frame](const std::string& text) {
                const std::size_t x = text.find('x');
                if (x == std::string::npos)
                    throw CLI::ValidationError("--size", "must be WxH, such as 640x360");
                frame.fields.emplace("width", text.substr(0, x));
                frame.fields.emplace("height", text.substr(x + 1));
            },
            "width and height in pixels")
        ->type_name("WxH");
    command
        .add_option_function<std::vector<std::string>>(
            "--effects",
            [&frame](const std::vector<std::string>& on) {
                // `all` and `none` stand alone.
                const bool all = on.size() == 1 && on.front() == "all";
                const bool none = on.size() == 1 && on.front() == "none";
                std::vector<std::string> unknown = on;
                std::string allowed = "all alone, none alone";
                Effects defaults;
                fields(defaults, [&](const char* name, bool, const Flag&, const char*) {
                    const bool isNamed = std::erase(unknown, name) > 0;
                    allowed += std::string(", ") + name;
                    frame.fields.emplace(std::string("effects.") + name,
                                         all || isNamed ? "1" : "0");
                });
                if (!unknown.empty() && !all && !none) {
                    throw CLI::ValidationError(
                        "--effects", "no effect \"" + unknown.front() + "\"; allowed: " + allowed);
                }
            },
            "enabled effects, separated by commas; or all, or none")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->type_name("LIST");
    command
        .add_option_function<std::vector<std::string>>(
            "--set",
            [&frame](const std::vector<std::string>& pairs) {
                for (const std::string& pair : pairs) {
                    const std::size_t equals = pair.find('=');
                    if (equals == std::string::npos) {
                        throw CLI::ValidationError(
                            "--set", "must be NAME=VALUE, such as effects.shadows=true");
                    }
                    frame.fields.emplace(pair.substr(0, equals), pair.substr(equals + 1));
                }
            },
            "any field, named as in a link; may be repeated")
        ->allow_extra_args(false)
        ->take_all()
        ->type_name("NAME=VALUE");
    addRendererFlags(command, line.config);
}

void addRender(CLI::App& app, CommandLine& line) {
    CLI::App* render = app.add_subcommand("render", "Render one frame into a file");
    render->callback([&line] { line.command = Command::render; });
    addFrameFlags(*render, line);
    render
        ->add_option("-o,--output", line.frame.output,
                     "output file: .jpg, .png, .webp, .npy, .exr or .json")
        ->required()
        ->type_name("FILE");
}

void addPlan(CLI::App& app, CommandLine& line) {
    CLI::App* plan = app.add_subcommand("plan", "Print the plan of a frame without rendering it");
    plan->callback([&line] { line.command = Command::plan; });
    addFrameFlags(*plan, line);
    plan->add_flag("--json", line.frame.planAsJson, "as JSON");
}

void addReferenceFlags(CLI::App& command, ReferenceCommand& reference) {
    static const std::map<std::string, ReferenceMode> kModes = {{"effects", ReferenceMode::effects},
                                                                {"full", ReferenceMode::full}};
    command.add_option("--samples", reference.samples, "paths per pixel of the reference")
        ->check(CLI::Range(2u, kMaxReferenceSamples).description(""))
        ->type_name("N")
        ->capture_default_str();
    command
        .add_option("--mode", reference.mode,
                    "full (all light transport) or effects (exact mirrors and glass, no shadows, "
                    "no light between surfaces); default full")
        ->transform(CLI::CheckedTransformer(kModes).description(""))
        ->type_name("MODE");
    command.add_option("--seed", reference.seed, "random seed")
        ->type_name("N")
        ->capture_default_str();
    command.add_option("--threads", reference.threads, "0: one for each processor")
        ->check(CLI::Range(0u, kMaxReferenceThreads).description(""))
        ->type_name("N")
        ->capture_default_str();
}

void addReference(CLI::App& app, CommandLine& line) {
    CLI::App* command = app.add_subcommand("reference", "Path trace the reference of a frame");
    command->callback([&line] { line.command = Command::reference; });
    addFrameFlags(*command, line);
    addReferenceFlags(*command, line.reference);
    command
        ->add_option("-o,--output", line.frame.output,
                     "output file: .exr, .npy, .pfm, .png, .webp or .jpg")
        ->required()
        ->type_name("FILE");
}

void addCompare(CLI::App& app, CommandLine& line) {
    CLI::App* command =
        app.add_subcommand("compare", "Compare accuracy settings with the path-traced reference");
    command->callback([&line] { line.command = Command::compare; });
    addFrameFlags(*command, line);
    addReferenceFlags(*command, line.reference);
    CompareCommand& compare = line.compare;
    command
        ->add_option(
            "--settings", compare.settings,
            "presets separated by commas, or a JSON list of accuracies; default: every preset")
        ->type_name("LIST");
    command
        ->add_option("--frames", compare.frames, "frames measured after warm-up for each setting")
        ->check(CLI::Range(1u, 200u).description(""))
        ->type_name("N")
        ->capture_default_str();
    command->add_option("-o,--output", compare.report, "a .json file for all results")
        ->type_name("FILE");
    command->add_option("--pictures", compare.pictures, "a folder for error images")
        ->type_name("FOLDER");
}

void addCompile(CLI::App& app, CommandLine& line) {
    CLI::App* command = app.add_subcommand(
        "compile", "Compile the shaders of the first frames of scenes into the shader cache");
    command->callback([&line] { line.command = Command::compile; });
    command
        ->add_option("scenes", line.compileScenes,
                     "model files, or ids of built-in scenes; default: all built-in scenes")
        ->type_name("SCENE");
    addRendererFlags(*command, line.config);
}

void addSequence(CLI::App& app, CommandLine& line) {
    CLI::App* command =
        app.add_subcommand("sequence", "Render many frames into a folder, or into a film");
    command->callback([&line] { line.command = Command::sequence; });
    addFrameFlags(*command, line);
    command->get_option("--request")
        ->required()
        ->description("a sequence as JSON, as for POST /v1/sequences; - reads standard input");
    command
        ->add_option("-o,--output", line.frame.output,
                     "output folder, where an interrupted run is resumed; or a film: FILE.mp4 or "
                     "FILE.webp")
        ->required()
        ->type_name("OUTPUT");
}

void addSign(CLI::App& app, CommandLine& line) {
    CLI::App* sign = app.add_subcommand("sign", "Sign a link to a frame for serve --link-key-file");
    sign->callback([&line] { line.command = Command::sign; });
    sign->add_option("link", line.sign.link, "path and query, from /v1/frames? on")
        ->required()
        ->type_name("LINK");
    sign->add_option("--key-file", line.sign.keyFile, "file whose first line is the key")
        ->required()
        ->type_name("FILE");
    sign->add_option("--valid", line.sign.validSeconds, "validity from now")
        ->check(CLI::Range(std::int64_t{1}, std::int64_t{100} * 366 * 24 * 3600).description(""))
        ->type_name("SECONDS")
        ->capture_default_str();
}

}  // namespace

std::optional<int> parseCommandLine(int argc, char** argv, CommandLine& line) {
    CLI::App app("Clerestory renders frames from camera poses.", "clerestory");
    app.require_subcommand(1);
    app.set_version_flag(
        "--version", [] { return versionReport(); }, "print version, build and libraries");
    addServe(app, line);
    addRender(app, line);
    addPlan(app, line);
    addReference(app, line);
    addCompare(app, line);
    addCompile(app, line);
    addSequence(app, line);
    addSign(app, line);
    app.add_subcommand("scenes", "List the built-in scenes")->callback([&line] {
        line.command = Command::scenes;
    });
    app.add_subcommand("devices", "List the EGL devices that --device selects")->callback([&line] {
        line.command = Command::devices;
    });
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& help) {  // --help and --version
        return app.exit(help);
    } catch (const CLI::ParseError& error) {
        const std::string message = error.what();
        std::cerr << "clerestory: " << message.substr(0, message.find('\n'))
                  << " (see clerestory --help)\n";
        return 2;
    }
    line.config.scenes.import.cache = sceneCacheOf(line.config.cache);
    storeLight(line.config.renderer.light, line.config.cache);
    line.config.renderer.light.background = line.command == Command::serve;  // others wait for it
    if (const auto folder = cacheFolderOf(line.config.cache); !folder.empty()) {
        line.config.curves = std::make_shared<CurveStore>(folder);
    }
    line.config.workers.program.arguments.assign(argv + std::min(argc, 2), argv + argc);
    return std::nullopt;
}

}  // namespace clerestory
