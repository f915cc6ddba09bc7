#include "scene/import/import_wire.h"

#include "scene/import/scene_cleaning.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <sstream>

namespace clerestory {
namespace {

constexpr std::array<const char*, 7> kReasons{"notFound", "unsupported", "malformed", "crashed",
                                              "timedOut", "memory",      "limit"};

}  // namespace

std::string_view nameOf(ImportError::Reason reason) {
    return kReasons[static_cast<std::size_t>(reason)];
}

std::string encoded(const ImportLimits& l) {
    std::ostringstream text;
    text << l.cpu.count() << ' ' << l.addressSpaceBytes << ' ' << l.fileBytes << ' '
         << l.maxTriangles << ' ' << l.maxNodes << ' ' << l.maxImagePixels << ' ' << l.maxFiles;
    return text.str();
}

ImportLimits decodedLimits(const std::string& text) {
    ImportLimits limits;
    std::istringstream in(text);
    std::int64_t cpu = 0;
    if (in >> cpu) {
        limits.cpu = std::chrono::seconds(cpu);
    }
    for (std::uint64_t* value : {&limits.addressSpaceBytes, &limits.fileBytes, &limits.maxTriangles,
                                 &limits.maxNodes, &limits.maxImagePixels, &limits.maxFiles}) {
        std::uint64_t read = 0;
        if (in >> read) {
            *value = read;
        }
    }
    return limits;
}

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

// The name stands last, with whatever is in it; the end of a line is written as what no name has.
std::string readingLine(const FileReading& reading) {
    std::ostringstream text;
    text << "file " << static_cast<int>(reading.outcome) << ' ' << reading.low << ' '
         << reading.high << ' ';
    for (const char c : reading.name) text << (c == '\n' ? '\0' : c);
    text << '\n';
    return text.str();
}

std::optional<FileReading> readReading(const std::string& line) {
    std::istringstream in(line);
    std::string word;
    int outcome = -1;
    FileReading reading;
    in >> word >> outcome >> reading.low >> reading.high;
    if (!in || word != "file" || outcome < 0 || outcome > 3 || in.get() != ' ') return std::nullopt;
    reading.outcome = static_cast<FileReading::Outcome>(outcome);
    std::getline(in, reading.name);
    std::replace(reading.name.begin(), reading.name.end(), '\0', '\n');
    return reading;
}

std::optional<ImportError> readError(const std::string& line) {
    constexpr std::string_view kStart = "error ";
    for (std::size_t i = 0; i < kReasons.size(); ++i) {
        const std::string start = std::string(kStart) + kReasons[i] + " ";
        if (line.starts_with(start)) {
            return ImportError(static_cast<ImportError::Reason>(i),
                               cleanText(line.substr(start.size())));
        }
    }
    return std::nullopt;
}

}  // namespace clerestory
