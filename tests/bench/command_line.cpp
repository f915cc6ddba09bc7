// See command_line.h.
#include "command_line.h"

#include <CLI/CLI.hpp>

namespace clerestory::bench {
namespace {

template <class Number>
void addNumber(CLI::App& app, const std::string& name, Number& value, const std::string& meaning,
               const Interval& interval) {
    CLI::Option* option = app.add_option(name, value, meaning)->take_last();
    if (interval.max < std::numeric_limits<double>::max()) {
        option->check(CLI::Range(interval.min, interval.max));
    }
}

}  // namespace

CommandLine::CommandLine(const std::string& purpose) : app_(std::make_unique<CLI::App>(purpose)) {}

CommandLine::~CommandLine() = default;

void CommandLine::add(const std::string& name, std::string& value, const std::string& meaning,
                      const Words& allowed) {
    CLI::Option* option = app_->add_option(name, value, meaning)->take_last();
    if (!allowed.empty()) option->check(CLI::IsMember(allowed));
}

void CommandLine::add(const std::string& name, int& value, const std::string& meaning,
                      const Interval& interval) {
    addNumber(*app_, name, value, meaning, interval);
}

void CommandLine::add(const std::string& name, std::uint32_t& value, const std::string& meaning,
                      const Interval& interval) {
    addNumber(*app_, name, value, meaning, interval);
}

void CommandLine::add(const std::string& name, double& value, const std::string& meaning,
                      const Interval& interval) {
    addNumber(*app_, name, value, meaning, interval);
}

void CommandLine::add(const std::string& name, std::filesystem::path& value,
                      const std::string& meaning) {
    app_->add_option(name, value, meaning)->take_last();
}

void CommandLine::addRequired(const std::string& name, std::string& value,
                              const std::string& meaning) {
    app_->add_option(name, value, meaning)->take_last()->required();
}

void CommandLine::addList(const std::string& name, Words& value, const std::string& meaning,
                          char separator) {
    CLI::Option* option = app_->add_option(name, value, meaning);
    if (separator != '\0') option->delimiter(separator);
}

void CommandLine::addFlag(const std::string& name, bool& value, const std::string& meaning) {
    app_->add_flag(name, value, meaning);
}

std::optional<int> CommandLine::parse(int argc, char** argv, Words* others) {
    app_->allow_extras(others != nullptr);
    try {
        app_->parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app_->exit(error);
    }
    if (others) *others = app_->remaining();
    return std::nullopt;
}

}  // namespace clerestory::bench
