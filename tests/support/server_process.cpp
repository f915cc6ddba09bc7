#include "tests/support/server_process.h"

#include "tests/support/raw_client.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

namespace clerestory::test {

ServerProcess::ServerProcess(const std::vector<std::string>& flags, void (*before)(),
                             const std::string& program) {
    std::vector<std::string> words = {program, "serve"};
    words.insert(words.end(), flags.begin(), flags.end());
    const auto unlessGiven = [&](const char* flag, const char* value) {
        if (std::find(flags.begin(), flags.end(), flag) != flags.end()) return;
        words.insert(words.end(), {flag, value});
    };
    unlessGiven("--port", "0");
    unlessGiven("--log-level", "off");
    unlessGiven("--scene-cache", "none");
    unlessGiven("--frame-cache", "0");            // tests repeat requests to draw again
    unlessGiven("--first-compile", "optimized");  // tests count renderers
    // A busy machine may take longer over a cold first frame than the usual deadline.
    unlessGiven("--deadline", "60");
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    int ends[2];
    if (::pipe(ends) != 0) return;
    id_ = ::fork();
    if (id_ == 0) {
        ::dup2(ends[1], 1);
        ::close(ends[0]);
        ::close(ends[1]);
        if (before) before();
        ::execv(arguments[0], arguments.data());
        ::_exit(127);
    }
    ::close(ends[1]);
    std::string line;
    for (char c; ::read(ends[0], &c, 1) == 1 && c != '\n';) line += c;
    ::close(ends[0]);
    const std::size_t colon = line.rfind(':');
    if (colon != std::string::npos) port_ = std::atoi(line.c_str() + colon + 1);
}

ServerProcess::~ServerProcess() {
    if (id_ > 0) end(SIGKILL);
}

void ServerProcess::signal(int number) const {
    ::kill(id_, number);
}

bool ServerProcess::ended() const {
    siginfo_t info{};
    return id_ <= 0 ||
           (::waitid(P_PID, static_cast<id_t>(id_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
            info.si_pid == id_);
}

bool ServerProcess::waitUntilReady() const {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(5);
    while (!ended() && std::chrono::steady_clock::now() < end) {
        if (statusOf(ask(port_, get("/readyz", "Connection: close\r\n"))) == 200) return true;
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return false;
}

int ServerProcess::wait() {
    int status = 0;
    ::waitpid(id_, &status, 0);
    id_ = -1;
    return status;
}

int ServerProcess::end(int number) {
    signal(number);
    return wait();
}

std::size_t ServerProcess::residentBytes() const {
    std::ifstream file("/proc/" + std::to_string(id_) + "/statm");
    std::size_t pages = 0, resident = 0;
    file >> pages >> resident;
    return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

namespace {

std::size_t entriesOf(const std::string& folder) {
    std::error_code error;
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
        (void)entry;
        ++count;
    }
    return count;
}

}  // namespace

std::size_t ServerProcess::descriptors() const {
    return entriesOf("/proc/" + std::to_string(id_) + "/fd");
}

std::size_t ServerProcess::threads() const {
    return entriesOf("/proc/" + std::to_string(id_) + "/task");
}

}  // namespace clerestory::test
