#include "accuracy_record.h"

#include "accuracy_text.h"

#include <map>
#include <sstream>
#include <stdexcept>

namespace clerestory::bench {
namespace {

// Names of scenes and settings of the short form hold no comma.
std::string keyOf(const Point& p) {
    return p.scene + "," + curveName(p.effect) + "," + p.setting;
}

std::map<std::string, double> readRecord(const std::string& record) {
    std::map<std::string, double> errors;
    std::istringstream lines(record);
    for (std::string line; std::getline(lines, line);) {
        if (line.empty() || line.front() == '#' || line.rfind("scene,", 0) == 0) continue;
        const std::size_t comma = line.rfind(',');
        char* end = nullptr;
        const double value =
            comma == std::string::npos ? 0.0 : std::strtod(line.c_str() + comma + 1, &end);
        if (!end || end == line.c_str() + comma + 1) {
            throw std::runtime_error("a row of the record has no error: " + line);
        }
        errors[line.substr(0, comma)] = value;
    }
    return errors;
}

}  // namespace

std::string recordOf(const Points& points, const std::string& renderer) {
    std::string out = "# relMSE of the short form of scripts/bench accuracy, by " + renderer +
                      "\n# written by bench_accuracy --short --record FILE\n"
                      "scene,effect,setting,relMse\n";
    for (const Point& p : points) out += keyOf(p) + text(",%.6g\n", p.relMse);
    return out;
}

Held heldAgainst(const std::string& record, const Points& points) {
    const std::map<std::string, double> errors = readRecord(record);
    Held result;
    for (const Point& p : points) {
        const auto found = errors.find(keyOf(p));
        if (found == errors.end()) {
            ++result.missing;
            continue;
        }
        ++result.held;
        if (p.relMse > kMaxGrowth * std::max(found->second, kMinError)) {
            result.exceeded.push_back(
                keyOf(p) + text(": relMSE %.6g, recorded %.6g", p.relMse, found->second));
        }
    }
    return result;
}

}  // namespace clerestory::bench
