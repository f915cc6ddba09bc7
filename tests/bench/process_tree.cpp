// Reads /proc.
#include "tests/bench/process_tree.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <utility>

namespace clerestory::bench {
namespace {

std::filesystem::path folderOf(pid_t id) {
    return "/proc/" + std::to_string(id);
}

std::size_t entries(const std::filesystem::path& folder) {
    std::error_code error;
    const std::filesystem::directory_iterator list(folder, error);
    return static_cast<std::size_t>(std::distance(begin(list), end(list)));
}

// In ticks since the machine's; numbers of processes come round again.
std::uint64_t startOf(pid_t id) {
    std::ifstream file(folderOf(id) / "stat");
    std::string text{std::istreambuf_iterator<char>(file), {}};
    // After the name, which may hold anything: the state and eighteen more.
    std::istringstream fields(text.substr(std::min(text.rfind(')') + 1, text.size())));
    std::string skipped;
    for (int i = 0; i < 19; ++i) fields >> skipped;
    std::uint64_t ticks = 0;
    fields >> ticks;
    return ticks;
}

// By walking the pages: the kernel's running counts, in statm, are up to a batch a processor off.
std::size_t residentBytes(pid_t id) {
    std::ifstream file(folderOf(id) / "smaps_rollup");
    std::size_t kilobytes = 0;
    for (std::string word; file >> word;) {
        if (word == "Rss:") file >> kilobytes;
    }
    return 1024 * kilobytes;
}

}  // namespace

std::string commandLineOf(pid_t id) {
    std::ifstream file(folderOf(id) / "cmdline");
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::vector<pid_t> workersOf(pid_t server) {
    std::vector<pid_t> list;
    std::error_code error;
    for (const auto& task : std::filesystem::directory_iterator(folderOf(server) / "task", error)) {
        std::ifstream children(task.path() / "children");
        for (pid_t id = 0; children >> id;) {
            if (commandLineOf(id).find("worker") != std::string::npos) list.push_back(id);
        }
    }
    std::sort(list.begin(), list.end(),
              [](pid_t a, pid_t b) { return std::pair(startOf(a), a) < std::pair(startOf(b), b); });
    return list;
}

Resources holdingsOf(pid_t server) {
    Resources sum;
    std::vector<pid_t> all = workersOf(server);
    all.push_back(server);
    for (const pid_t id : all) {
        sum.bytes += residentBytes(id);
        sum.descriptors += entries(folderOf(id) / "fd");
        sum.threads += entries(folderOf(id) / "task");
    }
    return sum;
}

}  // namespace clerestory::bench
