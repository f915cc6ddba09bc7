// Damages scene files in many ways and imports each: the result must be a valid scene or an error,
// within the time limit. scripts/fuzz scenes N [FOLDER]: without FOLDER the third-party scenes, and
// files with each kind of compression.
#include "tests/bench/bars.h"

#include "scene/import/import.h"

#include <unistd.h>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <random>
#include <thread>
#include <vector>

namespace {

using namespace clerestory;
using bench::Stopwatch;
namespace fs = std::filesystem;

constexpr std::uintmax_t kLargest = 300'000;          // bytes of a file that is damaged
constexpr std::uintmax_t kLargestFolder = 8'000'000;  // with all that it may refer to

std::string contentOf(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

// One of seven kinds of damage, up to four times.
std::string damaged(std::string bytes, std::mt19937_64& random) {
    const auto below = [&](std::size_t n) { return n > 0 ? random() % n : 0; };
    for (std::size_t times = 1 + below(4); times > 0 && !bytes.empty(); --times) {
        const std::size_t at = below(bytes.size());
        const std::size_t count = std::min(bytes.size() - at, std::size_t{1} + below(64));
        switch (below(7)) {
            case 0:
                bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
                break;
            case 1:
                bytes.resize(at);
                break;
            case 2:
                bytes.erase(at, count);
                break;
            case 3:
                bytes.insert(at, bytes.substr(below(bytes.size()), 1 + below(64)));
                break;
            case 4:
                for (std::size_t i = 0; i < count; ++i) bytes[at + i] = static_cast<char>(random());
                break;
            case 5:
                for (std::size_t i = 0; i < count; ++i) bytes[at + i] = static_cast<char>(0xff);
                break;
            default: {  // the next number of a text becomes another one
                constexpr const char* kNumbers[] = {"-1",  "4294967295", "1e39",
                                                    "nan", "0",          "99999999999999999999"};
                const std::size_t digit = bytes.find_first_of("0123456789", at);
                if (digit == std::string::npos) break;
                const std::size_t end =
                    std::min(bytes.find_first_not_of("0123456789.eE+-", digit), bytes.size());
                bytes.replace(digit, end - digit, kNumbers[below(std::size(kNumbers))]);
            }
        }
    }
    return bytes;
}

std::vector<fs::path> filesIn(const fs::path& folder) {
    std::vector<fs::path> files;
    const std::vector<std::string>& extensions = importableExtensions();
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        std::string extension = entry.path().extension().string();
        if (extension.empty() || !entry.is_regular_file() || entry.file_size() == 0 ||
            entry.file_size() > kLargest)
            continue;
        if (std::find(extensions.begin(), extensions.end(), extension.substr(1)) !=
            extensions.end()) {
            files.push_back(entry.path());
        }
    }
    std::sort(files.begin(), files.end());
    return files;
}

std::uintmax_t bytesIn(const fs::path& folder) {
    std::uintmax_t sum = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        if (entry.is_regular_file()) sum += entry.file_size();
    }
    return sum;
}

// The damaged files in copies of their folders, next to the files that they refer to, and the
// originals stay as they are.
std::vector<fs::path> copied(const std::vector<fs::path>& files, const fs::path& work) {
    std::map<fs::path, fs::path> copies;  // empty: too large
    std::vector<fs::path> result;
    for (const fs::path& file : files) {
        const fs::path folder = file.parent_path();
        if (!copies.contains(folder)) {
            fs::path copy;
            if (bytesIn(folder) <= kLargestFolder) {
                copy = work / std::to_string(copies.size());
                fs::copy(folder, copy, fs::copy_options::recursive);
            }
            copies[folder] = copy;
        }
        if (!copies[folder].empty()) result.push_back(copies[folder] / file.filename());
    }
    return result;
}

// Files that are no scenes before the damage are skipped.
std::vector<fs::path> loading(std::vector<fs::path> files, const ImportOptions& options) {
    std::erase_if(files, [&](const fs::path& file) {
        try {
            importScene(file, options);
            return false;
        } catch (const ImportError&) {
            return true;
        }
    });
    return files;
}

struct Tally {
    std::mutex mutex;
    std::map<std::string, int> outcomes;
    double slowest = 0.0;
    int failures = 0;
    void add(const std::string& outcome, double milliseconds, bool failed) {
        const std::lock_guard lock(mutex);
        ++outcomes[outcome];
        slowest = std::max(slowest, milliseconds);
        failures += failed;
    }
};

void tryOne(const fs::path& source, std::uint64_t number, const ImportOptions& options,
            Tally& tally) {
    std::mt19937_64 random(number);
    const fs::path file =
        source.parent_path() / ("damaged" + std::to_string(number) + source.extension().string());
    std::ofstream(file, std::ios::binary) << damaged(contentOf(source), random);
    const Stopwatch watch;
    try {
        const Scene scene = importScene(file, options);
        const bool sound = sceneProblems(scene).empty();
        tally.add(sound ? "a scene" : "A SCENE THAT IS NONE", watch.milliseconds(), !sound);
    } catch (const ImportError& error) {
        tally.add(std::string(nameOf(error.reason())), watch.milliseconds(), false);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s: %s\n", file.c_str(), error.what());
        tally.add("ANOTHER EXCEPTION", watch.milliseconds(), true);
    }
    fs::remove(file);
}

}  // namespace

int main(int argc, char** argv) {
    const std::uint64_t count = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 10'000;
    const fs::path folder = argc > 2 ? argv[2] : CLERESTORY_SHARED_SCENES;
    const fs::path work =
        fs::temp_directory_path() / ("clerestory-mutations-" + std::to_string(::getpid()));
    fs::create_directory(work);
    ImportOptions options{.importer = CLERESTORY_PROGRAM};
    options.limits.wallClock = std::chrono::milliseconds(10'000);
    options.limits.cpu = std::chrono::seconds(5);
    options.limits.addressSpaceBytes = 1ull << 30;
    std::vector<fs::path> files;
    if (fs::is_directory(folder)) files = filesIn(folder);
    if (argc <= 2) {
        for (const fs::path& file : filesIn(CLERESTORY_COMPRESSED_SCENES)) files.push_back(file);
    }
    files = loading(copied(files, work), options);
    if (files.empty()) {
        std::fprintf(stderr, "no scene file to damage in that folder\n");
        fs::remove_all(work);
        return 2;
    }
    Tally tally;
    std::atomic<std::uint64_t> next{0};
    {
        std::vector<std::jthread> threads;
        for (unsigned t = 0; t < std::max(1u, std::thread::hardware_concurrency()); ++t) {
            threads.emplace_back([&] {
                for (std::uint64_t n = next++; n < count; n = next++) {
                    tryOne(files[n % files.size()], n, options, tally);
                }
            });
        }
    }
    fs::remove_all(work);
    clerestory::bench::Bars bars;
    std::string outcomes;
    for (const auto& [outcome, times] : tally.outcomes) {
        outcomes += std::to_string(times) + " " + outcome + ", ";
    }
    bars.add({.row = "S1",
              .what = std::to_string(count) + " damaged copies of " + std::to_string(files.size()) +
                      " scene files",
              .figure = outcomes + std::to_string(tally.failures) + " failures",
              .bar = "0 failures",
              .held = tally.failures == 0});
    bars.add({.row = "S1",
              .what = "the slowest of them, of which the processor gave up to 5 s",
              .figure = std::to_string(std::lround(tally.slowest)) + " ms",
              .bar = "6000 ms",
              .held = true,
              .timely = tally.slowest <= 6000});
    return bars.end();
}
