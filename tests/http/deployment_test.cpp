// The files of deploy/ against the limits of the program: memory that adds up, and what a unit or a
// proxy must say so that one failure does not become that of all.
#include "server/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>

namespace clerestory::test {
namespace {

using testing::HasSubstr;

constexpr double kGiB = 1024.0 * 1024.0 * 1024.0;
// Measured by `scripts/bench memory`: the server itself, and a renderer besides its scenes.
constexpr double kServer = 0.15 * kGiB, kRenderer = 0.5 * kGiB;
// What both files reserve for the import of one large scene.
constexpr double kImport = 2.0 * kGiB;

std::string textOf(const std::string& name) {
    std::ifstream in(std::string(CLERESTORY_SOURCE_DIR) + "/deploy/" + name);
    std::ostringstream text;
    text << in.rdbuf();
    EXPECT_FALSE(text.str().empty()) << name;
    return text.str();
}

// The first group of the pattern as a number of bytes: "6G", "6Gi" or "1073741824".
double bytesIn(const std::string& text, const std::string& pattern) {
    std::smatch found;
    if (!std::regex_search(text, found, std::regex(pattern))) {
        ADD_FAILURE() << "nothing matches " << pattern;
        return 0.0;
    }
    std::size_t end = 0;
    const double number = std::stod(found[1].str(), &end);
    return found[1].str().substr(end).empty() ? number : number * kGiB;
}

double resident(double sceneMemory) {
    const Config config;
    const double server = kServer + static_cast<double>(config.http.limits.unsentBytes) +
                          static_cast<double>(config.http.limits.smallUnsentBytes) +
                          static_cast<double>(config.http.limits.largeBytes) +
                          static_cast<double>(config.frameCacheBytes);
    return server + 2.0 * (sceneMemory + kRenderer) + kImport;
}

TEST(Deployment, TheUnitsMemoryAddsUp) {
    const std::string unit = textOf("clerestory.service");
    const double limit = bytesIn(unit, "\nMemoryMax=(\\S+)");
    const double sum = resident(bytesIn(unit, "--scene-memory (\\S+)"));
    std::printf("the unit: %.2f GiB of %.2f GiB\n", sum / kGiB, limit / kGiB);
    EXPECT_LE(sum, limit);
    EXPECT_THAT(unit, HasSubstr("\nOOMPolicy=continue\n"))
        << "one renderer without memory must not end the unit";
}

TEST(Deployment, TheContainersMemoryAddsUp) {
    const std::string pod = textOf("kubernetes.yaml");
    const double limit = bytesIn(pod, "limits: \\{ memory: (\\S+) \\}");
    const double sum = resident(bytesIn(pod, "\"--scene-memory\", \"(\\d+)\""));
    std::printf("the container: %.2f GiB of %.2f GiB\n", sum / kGiB, limit / kGiB);
    EXPECT_LE(sum, limit);
    EXPECT_LT(bytesIn(pod, "\"--worker-memory\", \"(\\d+)\""), limit)
        << "a renderer must meet its own limit before that of the container";
}

}  // namespace
}  // namespace clerestory::test
