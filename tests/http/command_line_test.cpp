// The program itself, as a person starts it.
#include "image/encode.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace clerestory {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

struct Outcome {
    int exitCode = -1;
    std::string output;  // both streams
};

Outcome run(const std::string& arguments, const std::string& before = "") {
    const std::string command = before + " '" + CLERESTORY_PROGRAM + "' " + arguments + " 2>&1";
    Outcome outcome;
    FILE* pipe = ::popen(command.c_str(), "r");
    if (!pipe) return outcome;
    std::array<char, 4096> buffer;
    for (std::size_t n; (n = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) {
        outcome.output.append(buffer.data(), n);
    }
    outcome.exitCode = WEXITSTATUS(::pclose(pipe));
    return outcome;
}

std::string outputFile(const char* name) {
    std::filesystem::create_directories(CLERESTORY_TEST_OUTPUT);
    return std::string(CLERESTORY_TEST_OUTPUT) + "/" + name;
}

std::string content(const std::string& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

void expectOneLine(const Outcome& outcome) {
    EXPECT_EQ(outcome.exitCode, 2) << outcome.output;
    EXPECT_THAT(outcome.output, StartsWith("clerestory: "));
    EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 1) << outcome.output;
}

TEST(CommandLine, RendersTheFrameThatFlagsAskFor) {
    const std::string file = outputFile("flags.png");
    const Outcome outcome =
        run("render six-walls --eye 0.5,0.6,0.7 --target 0,0,0 --size 64x48 "
            "--accuracy draft --effects none -o '" +
            file + "'");
    ASSERT_EQ(outcome.exitCode, 0) << outcome.output;
    const Image image = decodePng(content(file));
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
    EXPECT_EQ(content(flags), content(json));
    EXPECT_FALSE(content(json).empty());
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

TEST(CommandLine, HelpIsForPeople) {
    const Outcome outcome = run("serve --help");
    EXPECT_EQ(outcome.exitCode, 0);
    for (const char* flag :
         {"--port", "--host", "--scene", "--scenes", "--environment", "--renderer", "--queue",
          "--deadline", "--max-body", "--threads", "--log-level"}) {
        EXPECT_THAT(outcome.output, HasSubstr(flag));
    }
    EXPECT_EQ(run("--help").exitCode, 0);
}

TEST(CommandLine, MistakesAreOneLineAndExitTwo) {
    for (const char* arguments :
         {"", "sevre", "serve --prot 1", "serve --port x", "serve --port 99999",
          "serve --renderer gpu", "serve --scene no-such-file.glb",
          "serve --host 256.1.1.1 --port 0", "serve --queue 0", "render six-walls",
          "render no-such-scene -o x.jpg", "render six-walls -o x.gif",
          "render six-walls --size 64 -o x.jpg", "render six-walls --size 0x9 -o x.jpg",
          "render six-walls --effects glow -o x.jpg", "render six-walls --set widht=3 -o x.jpg",
          "render six-walls --request no-such-file -o x.jpg",
          "render six-walls --camera nobody -o x.jpg", "plan six-walls --accuracy best"}) {
        SCOPED_TRACE(arguments);
        expectOneLine(run(arguments));
    }
}

TEST(CommandLine, NoDriverIsOneLineAndExitTwo) {
    const std::string broken =
        "MESA_GL_VERSION_OVERRIDE=3.0 LIBGL_DRIVERS_PATH=/nonexistent "
        "__EGL_VENDOR_LIBRARY_DIRS=/nonexistent";
    expectOneLine(run("serve --port 0", broken));
}

}  // namespace
}  // namespace clerestory
