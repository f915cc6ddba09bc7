// The command line of a benchmark. CLI11 is compiled once, for all of them.
//
//     int frames = 15;
//     CommandLine line("What a frame costs");
//     line.add("--frames", frames, "warm frames measured", {1, 1000});
//     if (const auto status = line.parse(argc, argv)) return *status;
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace clerestory::bench {

// Of a number; both ends included.
struct Interval {
    double min = std::numeric_limits<double>::lowest(), max = std::numeric_limits<double>::max();
};

class CommandLine {
public:
    using Words = std::vector<std::string>;

    explicit CommandLine(const std::string& purpose);
    ~CommandLine();

    // A name without dashes is a positional argument. A value that is not given keeps what it has;
    // of several the last counts. `allowed` empty: any.
    void add(const std::string& name, std::string& value, const std::string& meaning = "",
             const Words& allowed = {});
    void add(const std::string& name, int& value, const std::string& meaning = "",
             const Interval& interval = {});
    void add(const std::string& name, std::uint32_t& value, const std::string& meaning = "",
             const Interval& interval = {});
    void add(const std::string& name, double& value, const std::string& meaning = "",
             const Interval& interval = {});
    void add(const std::string& name, std::filesystem::path& value, const std::string& meaning);
    void addRequired(const std::string& name, std::string& value, const std::string& meaning);
    // Several words, which `separator` may divide, too.
    void addList(const std::string& name, Words& value, const std::string& meaning,
                 char separator = '\0');
    // "--name", or "--name,!--no-name".
    void addFlag(const std::string& name, bool& value, const std::string& meaning);

    // Empty: continue. Else help or an error was printed, and the program ends with this status.
    // What no option takes goes to `others`; without, it is an error.
    std::optional<int> parse(int argc, char** argv, Words* others = nullptr);

private:
    std::unique_ptr<CLI::App> app_;
};

}  // namespace clerestory::bench
