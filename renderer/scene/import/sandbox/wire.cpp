#include "scene/import/sandbox/wire.h"

#include "scene/import/base/cleaning.h"

#include <algorithm>
#include <charconv>
#include <sstream>

namespace clerestory {
std::string progressLine(const ImportProgress& progress) {
    const int permille = static_cast<int>(std::clamp(progress.progress, 0.0, 1.0) * 1000.0);
    return "progress " + std::to_string(permille) + " " + progress.stage + "\n";
}

std::string errorLine(ImportError::Reason reason, const std::string& message) {
    return "error " + std::string(nameOf(reason)) + " " + cleanText(message) + "\n";
}

std::optional<ImportProgress> readProgress(const std::string& line) {
    int permille = 0;
    constexpr std::string_view kStart = "progress ";
    const char* end = line.data() + line.size();
    if (!line.starts_with(kStart)) {
        return std::nullopt;
    }
    const auto read = std::from_chars(line.data() + kStart.size(), end, permille);
    if (read.ec != std::errc() || read.ptr == end || permille < 0 || permille > 1000) {
        return std::nullopt;
    }
    return ImportProgress{cleanText(std::string(read.ptr + 1, end)), permille / 1000.0};
}

// The name is last on the line. A newline in it is written as a zero byte, which no file name has.
std::string dependencyLine(const FileDependency& dependency) {
    std::ostringstream text;
    text << "file " << static_cast<int>(dependency.state) << ' ' << dependency.low << ' '
         << dependency.high << ' ';
    for (const char c : dependency.name) text << (c == '\n' ? '\0' : c);
    text << '\n';
    return text.str();
}

std::optional<FileDependency> readDependency(const std::string& line) {
    std::istringstream in(line);
    std::string word;
    int state = -1;
    FileDependency dependency;
    in >> word >> state >> dependency.low >> dependency.high;
    if (!in || word != "file" || state < 0 || state > 3 || in.get() != ' ') return std::nullopt;
    dependency.state = static_cast<FileDependency::State>(state);
    std::getline(in, dependency.name);
    std::replace(dependency.name.begin(), dependency.name.end(), '\0', '\n');
    return dependency;
}

std::optional<ImportError> readError(const std::string& line) {
    using Reason = ImportError::Reason;
    for (const Reason reason : {Reason::notFound, Reason::unsupported, Reason::malformed,
                                Reason::crashed, Reason::timedOut, Reason::memory, Reason::limit}) {
        const std::string start = "error " + std::string(nameOf(reason)) + " ";
        if (line.starts_with(start)) {
            return ImportError(reason, cleanText(line.substr(start.size())));
        }
    }
    return std::nullopt;
}

}  // namespace clerestory
