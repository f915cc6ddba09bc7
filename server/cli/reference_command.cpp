// `clerestory reference`: path traces one frame, as linear radiance or as displayed.
#include "server/api/encode_answer.h"
#include "server/cli/command_input.h"
#include "server/cli/commands.h"

#include "image/image.h"
#include "measures/displayed_errors.h"
#include "reference/reference.h"

#include <cmath>
#include <cstdio>
#include <fstream>

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

}  // namespace

int runReference(const CommandLine& line) {
    FrameCommand command = line.frame;
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

}  // namespace clerestory
