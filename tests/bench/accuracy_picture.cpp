// Diagrams of curves: a panel per scene, settings as points, the hull as a line.
#include "accuracy_report.h"
#include "accuracy_text.h"

#include <cmath>

namespace clerestory::bench {
namespace {

constexpr double kPanelWidth = 380.0, kPanelHeight = 268.0;  // with its labels; units of the SVG
constexpr double kLeft = 52.0, kRight = 14.0, kTop = 30.0, kBottom = 34.0;
constexpr double kHead = 62.0;
constexpr int kColumns = 3;

struct PresetMark {
    Preset preset;
    const char* name;
    const char* color;
};
constexpr PresetMark kMarks[] = {{Preset::draft, "draft", "#c2410c"},
                                 {Preset::standard, "standard", "#1d4ed8"},
                                 {Preset::fine, "fine", "#15803d"}};

std::string escaped(const std::string& plain) {
    std::string out;
    for (const char c : plain) {
        if (c == '<')
            out += "&lt;";
        else if (c == '&')
            out += "&amp;";
        else
            out += c;
    }
    return out;
}

// A logarithmic axis from a value below all to one above all.
struct Axis {
    double low = 0.0, high = 1.0;   // decadic logarithms
    double begin = 0.0, end = 1.0;  // where they lie
    double at(double value) const {
        const double t = (std::log10(value) - low) / (high - low);
        return begin + std::clamp(t, 0.0, 1.0) * (end - begin);
    }
    // 1, 2 and 5 of each decade; only 1 where that would be many.
    std::vector<double> ticks() const {
        std::vector<double> values;
        for (int decade = static_cast<int>(std::floor(low)); decade <= std::ceil(high); ++decade) {
            for (const double m : {1.0, 2.0, 5.0}) {
                if (m > 1.0 && high - low > 2.5) continue;
                const double value = m * std::pow(10.0, decade), l = std::log10(value);
                if (l >= low - 1e-9 && l <= high + 1e-9) values.push_back(value);
            }
        }
        return values;
    }
};

// At least `span` decades, with some room.
Axis axisOver(const std::vector<double>& values, double span, double begin, double end) {
    Axis axis{1e9, -1e9, begin, end};
    for (const double v : values) {
        axis.low = std::min(axis.low, std::log10(v));
        axis.high = std::max(axis.high, std::log10(v));
    }
    const double room = 0.08 * (axis.high - axis.low) + 0.04;
    axis.low -= room;
    axis.high += room;
    const double lacks = std::max(0.0, span - (axis.high - axis.low));
    axis.low -= 0.5 * lacks;
    axis.high += 0.5 * lacks;
    return axis;
}

std::string label(double x, double y, const char* anchor, const char* style,
                  const std::string& words) {
    return text("<text x='%.1f' y='%.1f' text-anchor='%s' %s>", x, y, anchor, style) +
           escaped(words) + "</text>\n";
}

std::string level(const Axis& x, double y, const char* color, const char* words) {
    return text("<path d='M%.1f %.1fH%.1f' stroke='%s' stroke-dasharray='4 3' fill='none'/>\n",
                x.begin, y, x.end, color) +
           label(x.end - 3.0, y - 3.0, "end", "font-size='9' fill='#6b7280'", words);
}

// Without what all settings of the sweep begin with.
std::string shortName(const std::string& setting) {
    const std::string start = "standard, ";
    return setting.rfind(start, 0) == 0 ? setting.substr(start.size()) : setting;
}

struct Box {
    double x0, y0, x1, y1;
    bool meets(const Box& o) const { return x0 < o.x1 && o.x0 < x1 && y0 < o.y1 && o.y0 < y1; }
};

class Panel {
public:
    Panel(const Curve& curve, double left, double top)
        : curve_(curve), left_(left), top_(top), costs_(costsOf(curve.points)) {
        std::vector<double> ms, errors;
        for (const CostAndError& c : costs_) {
            ms.push_back(c.milliseconds);
            errors.push_back(c.error);
        }
        const Point& first = curve.points.front();
        if (first.relMseOff > kMinError) errors.push_back(first.relMseOff);
        x_ = axisOver(ms, 0.6, left + kLeft, left + kPanelWidth - kRight);
        y_ = axisOver(errors, 0.8, top + kPanelHeight - kBottom, top + kTop);
    }

    std::string drawn() {
        for (const CostAndError& c : costs_) {
            const double x = x_.at(c.milliseconds), y = y_.at(c.error);
            taken_.push_back({x - 2.5, y - 2.5, x + 2.5, y + 2.5});
        }
        return label(left_ + kLeft, top_ + 20.0, "start", "font-size='13' font-weight='600'",
                     curve_.scene) +
               grid() + levels() + hullLine() + points() + presetMarks() + hullLabels();
    }

private:
    std::string grid() const {
        std::string out = text(
            "<rect x='%.1f' y='%.1f' width='%.1f' height='%.1f' fill='#fafafa' "
            "stroke='#d1d5db'/>\n",
            x_.begin, y_.end, x_.end - x_.begin, y_.begin - y_.end);
        const char* small = "font-size='10' fill='#4b5563'";
        for (const double v : x_.ticks()) {
            out +=
                text("<path d='M%.1f %.1fV%.1f' stroke='#e5e7eb'/>\n", x_.at(v), y_.end, y_.begin);
            out += label(x_.at(v), y_.begin + 13.0, "middle", small, text("%g", v));
        }
        for (const double v : y_.ticks()) {
            out +=
                text("<path d='M%.1f %.1fH%.1f' stroke='#e5e7eb'/>\n", x_.begin, y_.at(v), x_.end);
            out += label(x_.begin - 5.0, y_.at(v) + 3.5, "end", small, text("%.3g", v));
        }
        return out +
               label(0.5 * (x_.begin + x_.end), y_.begin + 27.0, "middle", small, "milliseconds");
    }

    std::string levels() const {
        const Point& first = curve_.points.front();
        std::string out;
        if (first.relMseOff > kMinError) {
            out += level(x_, y_.at(first.relMseOff), "#b91c1c",
                         curve_.effect == Effect::base ? "all effects off" : "effect off");
        }
        if (std::log10(std::max(first.relMseNoise, 1e-30)) > y_.low) {
            out += level(x_, y_.at(first.relMseNoise), "#9ca3af", "noise of the truth");
        }
        return out;
    }

    std::string hullLine() const {
        std::string path;
        for (const std::size_t i : lowerHull(costs_)) {
            path += text("%c%.1f %.1f", path.empty() ? 'M' : 'L', x_.at(costs_[i].milliseconds),
                         y_.at(costs_[i].error));
        }
        return "<path d='" + path + "' fill='none' stroke='#111827' stroke-width='1.4'/>\n";
    }

    std::string points() const {
        std::string out;
        for (std::size_t i = 0; i < costs_.size(); ++i) {
            const Point& p = curve_.points[i];
            if (p.preset) continue;
            out += text("<circle cx='%.1f' cy='%.1f' r='2.6' fill='#6b7280' fill-opacity='0.7'>",
                        x_.at(costs_[i].milliseconds), y_.at(costs_[i].error)) +
                   "<title>" + escaped(p.setting) +
                   text(": %.3g, %.1f ms</title></circle>\n", p.relMse, p.medianMs);
        }
        return out;
    }

    std::string presetMarks() {
        std::string out;
        for (std::size_t i = 0; i < costs_.size(); ++i) {
            const Point& p = curve_.points[i];
            if (!p.preset) continue;
            const double x = x_.at(costs_[i].milliseconds), y = y_.at(costs_[i].error);
            const PresetMark& mark = kMarks[static_cast<std::size_t>(*p.preset)];
            out += text("<rect x='%.1f' y='%.1f' width='9' height='9' fill='%s' stroke='#ffffff'>",
                        x - 4.5, y - 4.5, mark.color) +
                   "<title>" + escaped(p.setting) +
                   text(": %.3g, %.1f ms</title></rect>\n", p.relMse, p.medianMs);
            taken_.push_back({x - 5.0, y - 5.0, x + 5.0, y + 5.0});
            named_.push_back(
                {i, mark.name, text("font-size='11' font-weight='600' fill='%s'", mark.color)});
        }
        for (const Named& n : named_) out += placed(n.index, n.words, n.style, 6.4);
        return out;
    }

    std::string hullLabels() {
        std::string out;
        for (const std::size_t i : lowerHull(costs_)) {
            if (curve_.points[i].preset) continue;
            out +=
                placed(i, shortName(curve_.points[i].setting), "font-size='9' fill='#374151'", 4.7);
        }
        return out;
    }

    // Words near a point, where nothing else stands; nowhere if all is taken.
    std::string placed(std::size_t index, const std::string& words, const std::string& style,
                       double letter) {
        const double x = x_.at(costs_[index].milliseconds), y = y_.at(costs_[index].error);
        const double wide = letter * static_cast<double>(words.size());
        struct Place {
            double dx, dy;
        };
        std::vector<Place> places;
        for (const double away : {0.0, 12.0, 24.0, 40.0}) {
            places.insert(places.end(),
                          {Place{8.0, 4.0 + away}, Place{-8.0 - wide, 4.0 + away},
                           Place{-0.5 * wide, -8.0 - away}, Place{-0.5 * wide, 15.0 + away},
                           Place{8.0, -8.0 - away}, Place{-8.0 - wide, -8.0 - away}});
        }
        for (const Place place : places) {
            const Box box{x + place.dx, y + place.dy - 9.0, x + place.dx + wide,
                          y + place.dy + 2.0};
            bool free =
                box.x0 > x_.begin && box.x1 < x_.end && box.y0 > y_.end && box.y1 < y_.begin;
            for (const Box& other : taken_) free = free && !box.meets(other);
            if (!free) continue;
            taken_.push_back(box);
            return label(box.x0, y + place.dy, "start", style.c_str(), words);
        }
        return {};
    }

    struct Named {
        std::size_t index;
        const char* words;
        std::string style;
    };
    const Curve& curve_;
    double left_, top_;
    std::vector<CostAndError> costs_;
    Axis x_, y_;
    std::vector<Box> taken_;
    std::vector<Named> named_;
};

std::string head(Effect effect, Clock clock) {
    const bool frame = effect == Effect::base;
    std::string out = label(kLeft, 24.0, "start", "font-size='17' font-weight='700'",
                            frame ? "What accuracy costs: the whole frame"
                                  : "What accuracy costs: " + curveName(effect));
    out += label(kLeft, 44.0, "start", "font-size='11' fill='#4b5563'",
                 std::string("relMSE against the traced truth") +
                     (frame ? "" : ", on the effect's pixels,") + " by " + words(clock) +
                     " of a warm frame; a point for each setting, lower hull drawn");
    double x = kLeft;
    for (const PresetMark& mark : kMarks) {
        out += text("<rect x='%.1f' y='51' width='9' height='9' fill='%s'/>\n", x, mark.color) +
               label(x + 13.0, 59.5, "start", "font-size='11'", mark.name);
        x += 80.0;
    }
    return out;
}

}  // namespace

std::string svgOf(const Points& points, Effect effect, Clock clock) {
    std::vector<Curve> curves;
    for (Curve& c : curvesBy(points, clock)) {
        if (c.effect == effect) curves.push_back(std::move(c));
    }
    if (curves.empty()) return {};
    const int count = static_cast<int>(curves.size()), columns = kColumns;
    const int rows = (count + columns - 1) / columns;
    const double width = columns * kPanelWidth, height = kHead + rows * kPanelHeight + 8.0;
    std::string out = text(
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 %.0f %.0f' "
        "width='%.0f' height='%.0f' font-family='DejaVu Sans, Verdana, "
        "sans-serif' fill='#111827'>\n<rect width='100%%' height='100%%' "
        "fill='#ffffff'/>\n",
        width, height, width, height);
    out += head(effect, clock);
    for (int i = 0; i < count; ++i) {
        out += Panel(curves[static_cast<std::size_t>(i)], (i % columns) * kPanelWidth,
                     kHead + (i / columns) * kPanelHeight)
                   .drawn();
    }
    return out + "</svg>\n";
}

}  // namespace clerestory::bench
