#include "tests/bench/child_process.h"

#include "statistics.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <thread>

extern char** environ;

namespace clerestory::bench {
namespace {

constexpr double kPatienceMs = 20000;  // between SIGTERM and SIGKILL

std::vector<std::string> changed(const Environment& changes) {
    std::vector<std::string> all;
    for (char** entry = environ; *entry; ++entry) {
        const std::string text = *entry;
        if (!changes.contains(text.substr(0, text.find('=')))) all.push_back(text);
    }
    for (const auto& [name, value] : changes) {
        if (!value.empty()) all.push_back(name + "=" + value);
    }
    return all;
}

std::vector<char*> pointers(std::vector<std::string>& words) {
    std::vector<char*> list;
    for (std::string& word : words) list.push_back(word.data());
    list.push_back(nullptr);
    return list;
}

double seconds(const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

// A process that has ended but was not waited for has no command line.
bool runs(pid_t id) {
    std::ifstream file("/proc/" + std::to_string(id) + "/cmdline");
    return file.get() != std::char_traits<char>::eof();
}

bool anyRuns(const std::vector<pid_t>& processes) {
    return std::any_of(processes.begin(), processes.end(), runs);
}

}  // namespace

pid_t startProgram(std::vector<std::string> command, const Environment& changes,
                   const std::string& outputFile) {
    std::vector<std::string> environment = changed(changes);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    if (!outputFile.empty()) {
        posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, outputFile.c_str(),
                                         O_WRONLY | O_CREAT | O_TRUNC, 0600);
        posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
    }
    pid_t id = 0;
    const int error = posix_spawn(&id, command[0].c_str(), &actions, nullptr,
                                  pointers(command).data(), pointers(environment).data());
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) {
        throw std::runtime_error("cannot start " + command[0] + ": " + std::strerror(error));
    }
    return id;
}

Ended awaitEnd(pid_t id) {
    Ended result;
    rusage usage{};
    wait4(id, &result.status, 0, &usage);
    result.processorSeconds = seconds(usage.ru_utime) + seconds(usage.ru_stime);
    return result;
}

std::vector<pid_t> processTree(pid_t id) {
    std::vector<pid_t> tree = {id};
    for (std::size_t i = 0; i < tree.size(); ++i) {
        std::error_code error;
        const auto tasks = "/proc/" + std::to_string(tree[i]) + "/task";
        for (const auto& task : std::filesystem::directory_iterator(tasks, error)) {
            std::ifstream children(task.path() / "children");
            for (pid_t child = 0; children >> child;) tree.push_back(child);
        }
    }
    return tree;
}

double processorSeconds(const std::vector<pid_t>& processes) {
    double ticks = 0.0;
    for (const pid_t id : processes) {
        std::ifstream file("/proc/" + std::to_string(id) + "/stat");
        const std::string text{std::istreambuf_iterator<char>(file), {}};
        // Fields 14 to 17, counted from 1; the second is a name in brackets that may hold blanks.
        std::istringstream fields(text.substr(std::min(text.rfind(')') + 1, text.size())));
        std::string skipped;
        for (int i = 3; i < 14; ++i) fields >> skipped;
        for (int i = 14; i < 18; ++i) {
            double value = 0.0;
            fields >> value;
            ticks += value;
        }
    }
    return ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
}

void stopTree(pid_t id) {
    const std::vector<pid_t> tree = processTree(id);
    kill(id, SIGTERM);
    const Stopwatch watch;
    while (anyRuns(tree) && watch.milliseconds() < kPatienceMs) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    for (const pid_t one : tree) {
        if (runs(one)) kill(one, SIGKILL);
    }
    waitpid(id, nullptr, 0);
    while (anyRuns(tree)) std::this_thread::sleep_for(std::chrono::milliseconds(10));
}

}  // namespace clerestory::bench
