#include "accuracy_rows.h"

#include <cstdlib>
#include <sstream>
#include <stdexcept>

namespace clerestory::bench {
namespace {

constexpr std::size_t kFields = 19;

std::vector<std::string> cellsOf(const std::string& line) {
    std::vector<std::string> cells(1);
    bool quoted = false;
    for (const char c : line) {
        if (c == '"') {
            quoted = !quoted;
        } else if (c == ',' && !quoted) {
            cells.emplace_back();
        } else {
            cells.back() += c;
        }
    }
    return cells;
}

double number(const std::string& cell) {
    char* end = nullptr;
    const double value = std::strtod(cell.c_str(), &end);
    if (cell.empty() || *end != '\0') throw std::runtime_error("no number: \"" + cell + "\"");
    return value;
}

Point pointFrom(const std::string& line) {
    const std::vector<std::string> c = cellsOf(line);
    if (c.size() != kFields) throw std::runtime_error("a row of another length: " + line);
    Point p{.scene = c[0], .setting = c[2]};
    for (const Effect effect : kCurveEffects) {
        if (curveName(effect) == c[1]) p.effect = effect;
    }
    // It has rows but no curve.
    if (c[1] == curveName(Effect::materialLayers)) p.effect = Effect::materialLayers;
    for (const auto& [word, preset] : presetChoice().words) {
        if (word == p.setting) p.preset = preset;
    }
    const auto count = [&](std::size_t i) { return static_cast<std::uint64_t>(number(c[i])); };
    p.medianMs = number(c[3]);
    p.p95Ms = number(c[4]);
    p.coldMs = number(c[5]);
    p.processorMs = number(c[6]);
    p.totals = {count(7), count(8), count(9), count(10)};
    p.relMse = number(c[11]);
    p.relMseNoise = number(c[12]);
    p.relMseOff = number(c[13]);
    p.closedGap = number(c[14]);
    p.frameRelMse = number(c[15]);
    p.psnr = number(c[16]);
    p.decibels = number(c[17]);
    p.modelDecibels = number(c[18]);
    return p;
}

}  // namespace

Points pointsFrom(const std::string& csv) {
    Points points;
    std::istringstream lines(csv);
    for (std::string line; std::getline(lines, line);) {
        if (line.empty() || line.rfind("scene,", 0) == 0) continue;
        points.push_back(pointFrom(line));
    }
    return points;
}

}  // namespace clerestory::bench
