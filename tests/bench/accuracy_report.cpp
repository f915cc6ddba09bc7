#include "accuracy_report.h"

#include "accuracy_hull.h"
#include "accuracy_text.h"

#include <cmath>

namespace clerestory::bench {
namespace {

std::string quoted(const std::string& s) {
    return s.find(',') == std::string::npos ? s : '"' + s + '"';
}

const Point* presetOf(const Curve& curve, Preset preset) {
    for (const Point& p : curve.points) {
        if (p.preset == preset) return &p;
    }
    return nullptr;
}

// Errors below this multiple of the reference's noise are not significant to two digits.
constexpr double kNoiseShare = 5.0;

std::string errorText(const Point& p) {
    return text("%.2g", p.relMse) + (p.relMse < kNoiseShare * p.relMseNoise ? " (noise)" : "");
}

std::string presetTable(const std::vector<Curve>& curves) {
    std::string out =
        "| scene | effect | off | draft | standard | fine | noise "
        "|\n|---|---|---|---|---|---|---|\n";
    for (const Curve& curve : curves) {
        const Point& first = curve.points.front();
        out += text("| %s | %s | %.2g |", curve.scene.c_str(), curveName(curve.effect).c_str(),
                    first.relMseOff);
        for (const Preset preset : {Preset::draft, Preset::standard, Preset::fine}) {
            const Point* p = presetOf(curve, preset);
            out += p ? " " + errorText(*p) +
                           text(", %.0f ms, %.0f %% |", p->medianMs, 100.0 * p->closedGap)
                     : " |";
        }
        out += text(" %.1g |\n", first.relMseNoise);
    }
    return out;
}

std::string displayedTable(const std::vector<Curve>& curves) {
    std::string out = "| scene | draft | standard | fine |\n|---|---|---|---|\n";
    for (const Curve& curve : curves) {
        if (curve.effect != Effect::base) continue;
        out += "| " + curve.scene + " |";
        for (const Preset preset : {Preset::draft, Preset::standard, Preset::fine}) {
            const Point* p = presetOf(curve, preset);
            out += p ? text(" %.1f dB, PSNR %.1f |", p->modelDecibels, p->psnr) : " |";
        }
        out += "\n";
    }
    return out;
}

std::string hullTable(const std::vector<Curve>& curves) {
    std::string out = "| scene | effect | on the hull, cheapest first |\n|---|---|---|\n";
    for (const Curve& curve : curves) {
        const auto costs = costsOf(curve.points);
        out += "| " + curve.scene + " | " + curveName(curve.effect) + " | ";
        const char* between = "";
        for (const std::size_t i : lowerHull(costs)) {
            const Point& p = curve.points[i];
            out += text("%s%s (%.2g, %.0f ms)", between, p.setting.c_str(), p.relMse, p.medianMs);
            between = "; ";
        }
        out += " |\n";
    }
    return out;
}

std::string offHullList(const std::vector<Curve>& curves) {
    std::string out;
    for (const Curve& curve : curves) {
        const auto costs = costsOf(curve.points);
        for (std::size_t i = 0; i < curve.points.size(); ++i) {
            const Point& p = curve.points[i];
            const auto better = p.preset ? betterInBoth(costs, i, kOffHull) : std::nullopt;
            if (!better) continue;
            const Point& q = curve.points[*better];
            out += text("- %s, %s: `%s` (%.2g, %.0f ms) against `%s` (%.2g, %.0f ms)\n",
                        curve.scene.c_str(), curveName(curve.effect).c_str(), p.setting.c_str(),
                        p.relMse, p.medianMs, q.setting.c_str(), q.relMse, q.medianMs);
        }
    }
    return out.empty() ? "None.\n" : out;
}

// Geometric means over the scenes of one setting's error and time, as multiples of standard's.
struct Multiples {
    double logError = 0.0, logMs = 0.0;
    int scenes = 0;
};

Multiples multiplesOf(const std::vector<Curve>& curves, Effect effect, const std::string& setting) {
    Multiples m;
    for (const Curve& curve : curves) {
        const Point* standard = presetOf(curve, Preset::standard);
        if (curve.effect != effect || !standard) continue;
        for (const Point& p : curve.points) {
            if (p.setting != setting) continue;
            m.logError += std::log(errorFor(p) / errorFor(*standard));
            m.logMs += std::log(p.medianMs / standard->medianMs);
            ++m.scenes;
        }
    }
    return m;
}

std::vector<std::string> settingsOf(const std::vector<Curve>& curves) {
    std::vector<std::string> settings;
    for (const Curve& curve : curves) {
        for (const Point& p : curve.points) {
            if (std::find(settings.begin(), settings.end(), p.setting) == settings.end()) {
                settings.push_back(p.setting);
            }
        }
    }
    return settings;
}

std::string knobTable(const std::vector<Curve>& curves) {
    std::string out = "| setting |", rule = "|---|";
    for (const Effect effect : kCurveEffects) {
        out += " " + curveName(effect) + " |";
        rule += "---|";
    }
    out += "\n" + rule + "\n";
    for (const std::string& setting : settingsOf(curves)) {
        out += "| " + setting + " |";
        for (const Effect effect : kCurveEffects) {
            const Multiples m = multiplesOf(curves, effect, setting);
            out += m.scenes == 0
                       ? " |"
                       : text(" error x %.2f, time x %.2f (%d) |", std::exp(m.logError / m.scenes),
                              std::exp(m.logMs / m.scenes), m.scenes);
        }
        out += "\n";
    }
    return out;
}

}  // namespace

const char* words(Clock clock) {
    return clock == Clock::wall ? "median milliseconds" : "median processor milliseconds";
}

std::vector<Curve> curvesBy(const Points& points, Clock clock) {
    std::vector<Curve> curves = curvesOf(points);
    for (Curve& curve : curves) {
        for (Point& p : curve.points) {
            if (clock == Clock::processor) p.medianMs = p.processorMs;
        }
    }
    return curves;
}

std::string csvOf(const Points& points) {
    std::string out =
        "scene,effect,setting,medianMs,p95Ms,coldMs,processorMs,passes,views,draws,triangles,"
        "relMse,relMseNoise,relMseOff,closedGap,frameRelMse,psnr,decibels,"
        "modelDecibels\n";
    for (const Point& p : points) {
        out += quoted(p.scene) + "," + curveName(p.effect) + "," + quoted(p.setting);
        out += text(",%.2f,%.2f,%.1f,%.2f,%llu,%llu,%llu,%llu", p.medianMs, p.p95Ms, p.coldMs,
                    p.processorMs, static_cast<unsigned long long>(p.totals.passes),
                    static_cast<unsigned long long>(p.totals.views),
                    static_cast<unsigned long long>(p.totals.draws),
                    static_cast<unsigned long long>(p.totals.triangles));
        out += text(",%.6g,%.4g,%.6g,%.4f,%.6g,%.3f,%.3f,%.3f\n", p.relMse, p.relMseNoise,
                    p.relMseOff, p.closedGap, p.frameRelMse, p.psnr, p.decibels, p.modelDecibels);
    }
    return out;
}

std::string hullCsvOf(const Points& points, Clock clock) {
    std::string out = "scene,effect,setting,relMse,medianMs,onHull,better\n";
    const auto add = [&](const Curve& curve, const Point& p, bool onHull,
                         const std::string& better) {
        out += quoted(curve.scene) + "," + curveName(curve.effect) + "," + quoted(p.setting) +
               text(",%.3g,%.1f,%d,", p.relMse, p.medianMs, onHull ? 1 : 0) + quoted(better) + "\n";
    };
    for (const Curve& curve : curvesBy(points, clock)) {
        const auto costs = costsOf(curve.points);
        for (const std::size_t i : lowerHull(costs)) add(curve, curve.points[i], true, "");
        for (std::size_t i = 0; i < curve.points.size(); ++i) {
            if (!curve.points[i].preset) continue;
            const auto better = betterInBoth(costs, i, kOffHull);
            if (better) add(curve, curve.points[i], false, curve.points[*better].setting);
        }
    }
    return out;
}

std::string settingsCsvOf(const Points& points, Clock clock) {
    const std::vector<Curve> curves = curvesBy(points, clock);
    std::string out = "setting,effect,error,time,scenes\n";
    for (const std::string& setting : settingsOf(curves)) {
        for (const Effect effect : kCurveEffects) {
            const Multiples m = multiplesOf(curves, effect, setting);
            if (m.scenes == 0) continue;
            out += quoted(setting) + "," + curveName(effect) +
                   text(",%.2f,%.2f,%d\n", std::exp(m.logError / m.scenes),
                        std::exp(m.logMs / m.scenes), m.scenes);
        }
    }
    return out;
}

std::string markdownOf(const Points& points, Clock clock) {
    const std::vector<Curve> curves = curvesBy(points, clock);
    return "### Presets\n\nrelMSE on the effect's pixels, " + std::string(words(clock)) +
           " of a warm frame, closed gap; *off*: the same with the effect switched off; *noise*: "
           "of the truth; *(noise)*: less than five times that.\n\n" +
           presetTable(curves) +
           "\n### Presets as displayed\n\nYIQ decibels of the pixels that show the scene, PSNR of "
           "the whole "
           "picture.\n\n" +
           displayedTable(curves) + "\n### On the hull\n\n" + hullTable(curves) +
           "\n### Presets off the hull\n\nWorse than another setting in both error and time by "
           "over 5 %:\n\n" +
           offHullList(curves) +
           "\n### What each knob does\n\nGeometric means over the scenes (how many), as multiples "
           "of `standard`.\n\n" +
           knobTable(curves);
}

}  // namespace clerestory::bench
