// The program's command line.
#include "image/image.h"
#include "tests/support/program.h"
#include "tests/support/server_process.h"
#include "tests/support/soon.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <nlohmann/json.hpp>

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <sstream>
#include <thread>

namespace clerestory::test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

std::string outputFile(const char* name) {
    std::filesystem::create_directories(CLERESTORY_TEST_OUTPUT);
    return std::string(CLERESTORY_TEST_OUTPUT) + "/" + name;
}

void expectOneLine(const Outcome& outcome) {
    EXPECT_EQ(outcome.exitCode, 2) << outcome.output;
    EXPECT_THAT(outcome.output, StartsWith("clerestory: "));
    EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 1) << outcome.output;
}

// Of all files.
std::size_t bytesIn(const std::string& folder) {
    std::size_t bytes = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
        bytes += entry.is_regular_file() ? entry.file_size() : 0;
    }
    return bytes;
}

TEST(CommandLine, FlagsSetTheFrameRequest) {
    const std::string file = outputFile("flags.png");
    const Outcome outcome =
        run("render six-walls --eye 0.5,0.6,0.7 --target 0,0,0 --size 64x48 "
            "--accuracy draft --effects none -o '" +
            file + "'");
    ASSERT_EQ(outcome.exitCode, 0) << outcome.output;
    const Image image = decodePng(contentOf(file));
    EXPECT_EQ(image.width, 64u);
    EXPECT_EQ(image.height, 48u);
}

TEST(CommandLine, TakesTheSameJsonAsTheServer) {
    const std::string flags = outputFile("a.npy"), json = outputFile("b.npy");
    ASSERT_EQ(
        run("render six-walls --eye 0.5,0.6,0.7 --target 0,0,0 --size 64x48 -o '" + flags + "'")
            .exitCode,
        0);
    const Outcome outcome = run(
        "render six-walls --request - --size 64x48 -o '" + json + "'",
        R"(echo '{"camera": {"position": [0.5, 0.6, 0.7], "target": [0, 0, 0]}, "width": 9}' |)");
    ASSERT_EQ(outcome.exitCode, 0) << outcome.output;
    EXPECT_EQ(contentOf(flags), contentOf(json));
    EXPECT_FALSE(contentOf(json).empty());
}

// With the driver's optimisation passes and without.
TEST(CommandLine, ShaderCompilationModeDoesNotChangeTheBytes) {
    for (const char* scene : {"chapel", "teapots", "orbiting-cubes", "meadow", "six-walls"}) {
        std::vector<std::string> frames;
        for (const char* compilation : {"", "nopt"}) {
            const std::string file = outputFile("compilation.npy");
            const Outcome outcome =
                run(std::string("render ") + scene + " --size 96x54 -o '" + file + "'",
                    std::string("GALLIVM_PERF=") + compilation);
            ASSERT_EQ(outcome.exitCode, 0) << outcome.output;
            frames.push_back(contentOf(file));
        }
        EXPECT_EQ(frames[0], frames[1]) << scene;
    }
}

// llvmpipe has compiled variants again for what an earlier draw had left behind, for pictures whose
// edges are powers of two, and for programs that came from its cache.
TEST(CommandLine, ASecondRunCompilesNothing) {
    const std::string folder = outputFile("shader-cache");
    std::filesystem::remove_all(folder);
    std::vector<std::size_t> bytes;
    for (const char* size : {"96x54", "96x54", "96x54", "128x72", "64x64"}) {
        const Outcome outcome = run(
            "render teapots --size " + std::string(size) + " -o '" + outputFile("cached.png") + "'",
            "MESA_SHADER_CACHE_DIR='" + folder + "'");
        ASSERT_EQ(outcome.exitCode, 0) << outcome.output;
        bytes.push_back(bytesIn(folder));
    }
    EXPECT_GT(bytes[0], 0u);
    EXPECT_THAT(bytes, testing::Each(bytes[0]));
}

// The small passes of a warm-up must give the driver the same cases as frames do. When the edges of
// a map of shadows could be powers of two, a draft frame added 8 %.
TEST(CommandLine, FramesOfACompiledSceneCompileNextToNothing) {
    const std::string folder = outputFile("warm-shader-cache");
    std::filesystem::remove_all(folder);
    const std::string cache = " --shader-cache '" + folder + "' ";
    ASSERT_EQ(run("compile chapel" + cache).exitCode, 0);
    const std::size_t compiled = bytesIn(folder);
    EXPECT_GT(compiled, 0u);
    for (const char* accuracy : {"standard", "draft"}) {
        const Outcome outcome =
            run("render chapel --size 320x180 --accuracy " + std::string(accuracy) + cache +
                "-o '" + outputFile("warm.jpg") + "'");
        ASSERT_EQ(outcome.exitCode, 0) << outcome.output;
    }
    EXPECT_LT(bytesIn(folder) - compiled, compiled / 20);
}

TEST(CommandLine, PrintsLibrariesAndTheirVersions) {
    const Outcome outcome = run("--version");
    EXPECT_EQ(outcome.exitCode, 0);
    EXPECT_THAT(outcome.output, StartsWith("clerestory "));
    for (const char* name : {"assimp", "cpp-httplib", "libarchive", "libjpeg-turbo", "libpng",
                             "nlohmann-json", "OpenSSL", "embree", "zlib", "draco", "libavformat",
                             "libavif", "libwebp", "meshoptimizer"}) {
        EXPECT_THAT(outcome.output,
                    testing::ContainsRegex(std::string("\n  ") + name + " [0-9]+[.]"));
    }
    // The renderer string of /v1/renderer: with Mesa, its version.
    EXPECT_THAT(outcome.output, testing::ContainsRegex("\n  OpenGL [4-9][.][0-9]"));
    // X2: what is known of them is written down, with a date and what guards against each.
    EXPECT_THAT(outcome.output, HasSubstr("SECURITY.md"));
    const std::string security = contentOf(CLERESTORY_SOURCE_DIR "/SECURITY.md");
    EXPECT_THAT(security, HasSubstr("## Known weaknesses of libraries, as of 20"));
    EXPECT_THAT(security, testing::ContainsRegex("CVE-20[0-9][0-9]-[0-9]+"));
}

TEST(CommandLine, TracesAReference) {
    const std::string arguments =
        "reference six-walls --eye 0.5,0.6,0.7 --target 0,0,0 --size 32x24 --samples 4 ";
    const std::string numbers = outputFile("truth.npy"), picture = outputFile("truth.png");
    const std::string again = outputFile("again.npy"), pfm = outputFile("truth.pfm");
    const Outcome outcome = run(arguments + "--threads 1 -o '" + numbers + "'");
    ASSERT_EQ(outcome.exitCode, 0) << outcome.output;
    EXPECT_THAT(outcome.output, HasSubstr("tracing 100 %"));
    EXPECT_THAT(outcome.output, HasSubstr("4 samples per pixel, noise "));
    const Image image = decodeNpy(contentOf(numbers));
    EXPECT_EQ(image.width, 32u);
    EXPECT_EQ(image.height, 24u);
    EXPECT_EQ(image.channels, 3u);
    ASSERT_EQ(run(arguments + "--threads 3 -o '" + again + "'").exitCode, 0);
    EXPECT_EQ(contentOf(numbers), contentOf(again));
    ASSERT_EQ(run(arguments + "--mode full --seed 7 -o '" + picture + "'").exitCode, 0);
    EXPECT_EQ(decodePng(contentOf(picture)).width, 32u);
    ASSERT_EQ(run(arguments + "-o '" + pfm + "'").exitCode, 0);
    EXPECT_THAT(contentOf(pfm), StartsWith("PF\n32 24\n-1.0\n"));
    EXPECT_EQ(contentOf(pfm).size(), 14 + 4 * image.width * image.height * 3);
}

TEST(CommandLine, AMissingMapInASideFileIsAWarning) {
    const std::string quad = R"({"asset": {"version": "2.0"}, "nodes": [{"mesh": 0}],
      "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
      "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                     "min": [0, 0, 0], "max": [1, 1, 0]}],
      "bufferViews": [{"buffer": 0, "byteLength": 36}],
      "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,)";
    // (0, 0, 0), (1, 0, 0), (0, 1, 0)
    const std::string corners = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    const std::string model = outputFile("hall.gltf"), side = outputFile("hall.clerestory.json");
    std::ofstream(model) << quad << corners << R"("}]})";
    std::ofstream(side) << R"({"environment": {"map": "not-at-hand"}})";
    const std::string view = "'" + model + "' --eye 0.3,0.3,2 --target 0.3,0.3,0 --size 32x24 ";
    const std::string warning = "warning: unknownEnvironment 'not-at-hand': ";
    const std::string missing = outputFile("missing.npy"), sky = outputFile("sky.npy");

    const Outcome drawn = run("render " + view + "-o '" + missing + "'");
    EXPECT_EQ(drawn.exitCode, 0) << drawn.output;
    EXPECT_THAT(drawn.output, HasSubstr(warning));
    const Outcome traced =
        run("reference " + view + "--samples 4 -o '" + outputFile("missing.png") + "'");
    EXPECT_EQ(traced.exitCode, 0) << traced.output;
    EXPECT_THAT(traced.output, HasSubstr(warning));

    // Names in a request must exist.
    EXPECT_EQ(run("render " + view + "--set environment.map=not-at-hand -o x.npy").exitCode, 2);

    std::filesystem::remove(side);
    EXPECT_EQ(run("render " + view + "-o '" + sky + "'").output, "");
    EXPECT_EQ(contentOf(missing), contentOf(sky));
    EXPECT_FALSE(contentOf(sky).empty());
}

TEST(CommandLine, PrintsPlans) {
    EXPECT_THAT(run("plan six-walls").output, HasSubstr("run   surface"));
    const Outcome json = run("plan six-walls --json");
    EXPECT_FALSE(nlohmann::json::parse(json.output)["passes"].empty());
}

TEST(CommandLine, ListsTheBuiltInScenes) {
    const Outcome outcome = run("scenes");
    EXPECT_EQ(outcome.exitCode, 0);
    EXPECT_THAT(outcome.output, HasSubstr("chapel"));
    EXPECT_THAT(outcome.output, HasSubstr("six-walls"));
}

// Every device that has a driver draws the same frame as the driver that is found without --device,
// if it is the same driver.
TEST(CommandLine, ADeviceIsSelected) {
    const Outcome list = run("devices");
    ASSERT_EQ(list.exitCode, 0) << list.output;
    const std::string frame = "render six-walls --size 32x24 -o '", file = outputFile("device.png");
    std::istringstream lines(list.output);
    std::size_t count = 0, software = 0;
    for (std::string line; std::getline(lines, line); ++count) {
        EXPECT_THAT(line, StartsWith(std::to_string(count) + "  "));
        if (line.find(", software") == std::string::npos) continue;
        ++software;
        const std::string device = " --device " + std::to_string(count);
        ASSERT_EQ(run(frame + file + "' --renderer software" + device).exitCode, 0) << line;
        const std::string onDevice = contentOf(file);
        ASSERT_EQ(run(frame + file + "' --renderer software").exitCode, 0);
        EXPECT_EQ(onDevice, contentOf(file)) << line;
        const Outcome other = run(frame + file + "' --renderer hardware" + device);
        expectOneLine(other);
        EXPECT_THAT(other.output, HasSubstr("has a software driver"));
    }
    EXPECT_GT(software, 0u) << list.output;
    const Outcome none = run(frame + file + "' --device " + std::to_string(count));
    expectOneLine(none);
    EXPECT_THAT(none.output, HasSubstr("no EGL device " + std::to_string(count)));
}

TEST(CommandLine, HelpIsReadable) {
    const Outcome outcome = run("serve --help");
    EXPECT_EQ(outcome.exitCode, 0);
    for (const char* flag :
         {"--port",         "--host",         "--scene",        "--scenes",
          "--environment",  "--renderer",     "--queue",        "--deadline",
          "--max-body",     "--threads",      "--log-level",    "--queue-seconds",
          "--connections",  "--max-line",     "--max-path",     "--max-head",
          "--max-headers",  "--head-seconds", "--body-seconds", "--write-seconds",
          "--idle-seconds", "--allow-host",   "--token-file",   "--link-key-file",
          "--client-header"}) {
        EXPECT_THAT(outcome.output, HasSubstr(flag));
    }
    EXPECT_EQ(run("--help").exitCode, 0);
}

TEST(CommandLine, UsageErrorsPrintOneLineAndExitWith2) {
    for (const char* arguments : {"",
                                  "sevre",
                                  "serve --prot 1",
                                  "serve --port x",
                                  "serve --port 99999",
                                  "serve --renderer gpu",
                                  "serve --scene no-such-file.glb",
                                  "serve --host 256.1.1.1 --port 0",
                                  "serve --queue 0",
                                  "serve --head-seconds 0",
                                  "serve --port 0 --token-file no-such-file",
                                  "serve --port 0 --link-key-file /dev/null",
                                  "sign /v1/frames --key-file no-such-file",
                                  "render six-walls",
                                  "render no-such-scene -o x.jpg",
                                  "render six-walls -o x.gif",
                                  "render six-walls --size 64 -o x.jpg",
                                  "render six-walls --size 0x9 -o x.jpg",
                                  "render six-walls --effects glow -o x.jpg",
                                  "render six-walls --effects all,glow -o x.jpg",
                                  "render six-walls --effects none,shadows -o x.jpg",
                                  "render six-walls --set widht=3 -o x.jpg",
                                  "render six-walls --request no-such-file -o x.jpg",
                                  "render six-walls --camera unknown -o x.jpg",
                                  "plan six-walls --accuracy best",
                                  "reference six-walls -o x.gif",
                                  "reference six-walls --samples 1 -o x.exr",
                                  "reference six-walls --mode best -o x.exr",
                                  "reference six-walls --channel depth -o x.npy"}) {
        SCOPED_TRACE(arguments);
        expectOneLine(run(arguments));
    }
}

TEST(CommandLine, ErrorsSayWhatIsAllowed) {
    const auto says = [](const std::string& arguments, const std::string& before = "") {
        const Outcome outcome = run(arguments, before);
        EXPECT_EQ(outcome.exitCode, 2);
        return outcome.output;
    };
    EXPECT_THAT(says("plan six-walls --accuracy best"), HasSubstr("draft, standard, fine"));
    EXPECT_THAT(says("plan six-walls --yfov 9"), HasSubstr("a number from 0.017"));
    EXPECT_THAT(says("plan six-walls --effects glow"), HasSubstr("planarReflection"));
    EXPECT_THAT(says("plan six-walls --size 64"), HasSubstr("640x360"));
    EXPECT_THAT(says("reference six-walls -o x.json"), HasSubstr(".pfm"));
    EXPECT_THAT(says("plan six-walls --clip dance"), HasSubstr("allowed: "));
    EXPECT_THAT(says("serve --rays gpu"), HasSubstr("cpu"));
    EXPECT_THAT(says("serve --port 99999"), HasSubstr("65535"));
    EXPECT_THAT(says("serve --allow-origin shop.example"), HasSubstr("SCHEME://HOST"));
    EXPECT_THAT(says("serve --allow-origin https://shop.example/"), HasSubstr("SCHEME://HOST"));
    // One line for each wrong field.
    const std::string several =
        says("plan six-walls --request -", R"(echo '{"width": 0, "lights": [{"radius": -1}]}' |)");
    EXPECT_EQ(std::count(several.begin(), several.end(), '\n'), 2) << several;
    EXPECT_THAT(several, HasSubstr("/width is out of range; allowed: a whole number from 1 to "));
    EXPECT_THAT(several,
                HasSubstr("/lights/0/radius is out of range; allowed: a number from 0 to "));
}

// A URL with an address of IPv6 has brackets.
TEST(CommandLine, AnAddressOfIPv6HasBrackets) {
    EXPECT_THAT(run("serve --host 2001:db8::1 --port 81").output,
                HasSubstr("cannot listen on [2001:db8::1]:81: "));
    EXPECT_THAT(run("serve --host [2001:db8::1] --port 81").output,
                HasSubstr("cannot listen on [2001:db8::1]:81: "));
}

TEST(CommandLine, SignalsEndTheServerAfterTheCurrentFrame) {
    for (const int signal : {SIGTERM, SIGINT}) {
        test::ServerProcess server;
        ASSERT_GT(server.port(), 0);
        ASSERT_TRUE(server.waitUntilReady());
        std::thread frame([&] {
            httplib::Client client("127.0.0.1", server.port());
            client.set_read_timeout(60);
            const auto result =
                client.Post("/v1/frames", R"({"scene": "chapel"})", "application/json");
            // The signal may arrive before the frame is requested.
            EXPECT_THAT(result ? result->status : 0, testing::AnyOf(200, 503));
        });
        httplib::Client client("127.0.0.1", server.port());
        within(std::chrono::seconds(2), [&] {
            const auto metrics = client.Get("/metrics");
            return metrics && metrics->body.find("queue_depth 1\n") != std::string::npos;
        });
        const int status = server.end(signal);
        frame.join();
        EXPECT_TRUE(WIFEXITED(status)) << "ended by a signal";
        EXPECT_EQ(WEXITSTATUS(status), 0);
    }
}

// A3 of the failure catalogue, from the command that signs to the frame.
TEST(CommandLine, ASignedLinkIsValidForItsFrameOnly) {
    const std::string key = outputFile("link-key");
    std::ofstream(key) << "0123456789abcdef-a-key\n";
    const std::string frame = "/v1/frames?scene=six-walls&width=64&height=48";
    const auto linkFor = [&](const std::string& target) {
        std::string line = run("sign '" + target + "' --key-file '" + key + "'").output;
        return line.substr(0, line.find('\n'));
    };
    const std::string link = linkFor(frame);
    EXPECT_THAT(link, StartsWith(frame + "&expires="));
    test::ServerProcess server({"--scene", "six-walls", "--link-key-file", key});
    ASSERT_TRUE(server.waitUntilReady());
    httplib::Client client("127.0.0.1", server.port());
    client.set_read_timeout(60);
    const auto shown = client.Get(link);
    ASSERT_TRUE(shown);
    EXPECT_EQ(shown->status, 200) << shown->body;
    EXPECT_EQ(shown->get_header_value("Content-Type"), "image/jpeg");
    EXPECT_EQ(client.Get(frame)->status, 403);
    EXPECT_EQ(client.Get(link + "0")->status, 403);
    std::string larger = link;
    larger.replace(larger.find("width=64"), 8, "width=99");
    EXPECT_EQ(client.Get(larger)->status, 403);
}

TEST(CommandLine, AMissingDriverPrintsOneLineAndExitsWith2) {
    const std::string broken =
        "MESA_GL_VERSION_OVERRIDE=3.0 LIBGL_DRIVERS_PATH=/nonexistent "
        "__EGL_VENDOR_LIBRARY_DIRS=/nonexistent";
    expectOneLine(run("serve --port 0", broken));
}

}  // namespace
}  // namespace clerestory::test
