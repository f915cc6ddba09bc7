// Commands that trace a reference. `clerestory reference` path traces one frame, as linear radiance
// or as displayed; `compare` compares accuracy settings with the path-traced reference of a view.
#include "server/cli/commands.h"

#include "server/api/comparison_json.h"
#include "server/api/encode_answer.h"
#include "server/api/frame_json.h"
#include "server/jobs/jobs.h"

#include "image/image.h"
#include "measures/errors.h"
#include "reference/reference.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>

namespace clerestory {
namespace {

// Portable float map: three floats per pixel, little endian, last row first.
Bytes encodePfm(const Image& image) {
    Bytes bytes =
        "PF\n" + std::to_string(image.width) + " " + std::to_string(image.height) + "\n-1.0\n";
    const std::size_t row = std::size_t{image.width} * 3 * sizeof(float);
    for (std::uint32_t y = image.height; y-- > 0;) {
        bytes.append(reinterpret_cast<const char*>(image.data.data()) + y * row, row);
    }
    return bytes;
}

Bytes encodedReference(const Image& color, const FrameRequest& request) {
    const bool floats =
        request.output.format == OutputFormat::npy || request.output.format == OutputFormat::exr;
    if (floats) return encoded(color, request.output);
    const auto exposure = static_cast<float>(std::exp2(request.exposure));
    return encoded(quantised(displayed(color, request.toneMap, exposure)), request.output);
}

void writeReport(const std::filesystem::path& path, const std::string& bytes) {
    std::ofstream file(path, std::ios::binary);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!file) throw std::runtime_error("cannot write \"" + path.string() + "\"");
}

// "draft,fine", or a JSON list.
nlohmann::json settingsIn(const std::string& text) {
    if (!text.empty() && text.front() == '[') return strictJson(text);
    nlohmann::json list = nlohmann::json::array();
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        list.push_back(text.substr(begin, end - begin));
        begin = end + 1;
    }
    return list;
}

ComparisonRequest comparisonFor(const CommandLine& line) {
    ComparisonRequest request =
        comparisonRequestFrom(nlohmann::json{{"settings", settingsIn(line.compare.settings)}});
    FrameCommand command = line.frame;
    command.output.clear();
    request.frame = requestFor(command);
    request.mode = line.reference.mode;
    request.samples = line.reference.samples;
    request.seed = static_cast<std::uint32_t>(line.reference.seed);
    request.frames = line.compare.frames;
    request.errorPictures = !line.compare.pictures.empty();
    if (auto errors = problems(request); !errors.empty()) {
        throw RequestError(invalidFields(std::move(errors)));
    }
    return request;
}

// "standard, probeSize 512" -> "standard-probeSize-512"
std::string fileName(const std::string& name) {
    std::string text;
    for (const char c : name) {
        const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.';
        if (plain) {
            text += c;
        } else if (text.empty() || text.back() != '-') {
            text += '-';
        }
    }
    return text;
}

}  // namespace

int runReference(const CommandLine& line) {
    FrameCommand command = line.frame;
    static constexpr std::array kExtensions{".exr",  ".npy", ".pfm", ".png",
                                            ".webp", ".jpg", ".jpeg"};
    if (std::none_of(kExtensions.begin(), kExtensions.end(),
                     [&](const char* end) { return command.output.ends_with(end); })) {
        throw std::runtime_error(
            "the output of a reference must end in .exr, .npy, .pfm, .png, .webp or .jpg");
    }
    const bool asPfm = command.output.ends_with(".pfm");
    if (asPfm)
        command.output = "reference.npy";  // requestFor() has no .pfm; the format is replaced below
    FrameRequest request = requestFor(command);
    if (request.output.channel != Channel::color) {
        throw std::runtime_error("reference supports the channel color only");
    }
    if (!request.filters.empty()) {
        throw std::runtime_error(
            "reference does not support filters; remove them from the request");
    }
    const EnvironmentMaps maps = environmentsOf(line, request);
    const Scene scene = sceneFor(line, maps);
    const EnvironmentMap& lighting = lightingOf(maps, scene, request);

    ProgressLine progress("tracing");
    const auto reference = traceReference({.scene = scene,
                                           .frame = request,
                                           .environment = lighting,
                                           .maps = maps,
                                           .mode = line.reference.mode,
                                           .samples = line.reference.samples,
                                           .seed = line.reference.seed,
                                           .threads = line.reference.threads},
                                          [&](double fraction) {
                                              progress.show(fraction);
                                              return true;
                                          });
    progress.end();
    const Bytes bytes =
        asPfm ? encodePfm(reference->color) : encodedReference(reference->color, request);
    std::ofstream file(line.frame.output, std::ios::binary);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!file) throw std::runtime_error("cannot write \"" + line.frame.output + "\"");
    std::fprintf(stderr, "%u samples per pixel, noise %.3g\n", reference->samples,
                 reference->noiseFloor);
    return 0;
}

int runCompare(const CommandLine& line) {
    ComparisonRequest request = comparisonFor(line);
    const EnvironmentMaps maps = environmentsOf(line, request.frame);
    Scene scene = sceneFor(line, maps);
    scene.id = request.frame.scene = "scene";
    const EnvironmentMap& lighting = lightingOf(maps, scene, request.frame);

    ProgressLine tracing("tracing");
    const auto start = Clock::now();
    auto image = traceReference({.scene = scene,
                                 .frame = request.frame,
                                 .environment = lighting,
                                 .maps = maps,
                                 .mode = request.mode,
                                 .samples = request.samples,
                                 .seed = request.seed,
                                 .threads = line.reference.threads},
                                [&](double fraction) {
                                    tracing.show(fraction);
                                    return true;
                                });
    tracing.end();
    const ReferenceRender reference{*std::move(image), millisecondsSince(start)};

    Renderer renderer(line.config.renderer);
    for (const auto& [name, map] : maps) renderer.addEnvironment(map);
    renderer.addScene(scene);
    ProgressLine drawing("drawing");
    const auto comparison = compare(
        request, scene, reference,
        [&](const FrameRequest& frame) {
            requireLight(renderer, frame);
            return drawTimed(renderer, frame);
        },
        [&](double fraction) {
            drawing.show(fraction);
            return true;
        });
    drawing.end();
    std::cout << comparisonTable(*comparison);
    if (!line.compare.report.empty()) {
        writeReport(line.compare.report, comparisonJson(*comparison).dump(2) + "\n");
    }
    for (const SettingResult& setting : comparison->settings) {
        if (setting.errorPicture.data.empty()) continue;
        std::filesystem::create_directories(line.compare.pictures);
        writeReport(
            std::filesystem::path(line.compare.pictures) / (fileName(setting.name) + ".png"),
            encodePng(setting.errorPicture));
    }
    return 0;
}

}  // namespace clerestory
