// Runs the program's command line.
#pragma once

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace clerestory::test {

struct Outcome {
    int exitCode = -1;
    std::string output;  // both streams
};

// `before` stands before the program on the shell's line: settings of its environment.
inline Outcome run(const std::string& arguments, const std::string& before = "") {
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

inline std::string contentOf(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

}  // namespace clerestory::test
