#include "comparison/comparison_request.h"

#include "scene/field_values.h"

#include <algorithm>

namespace clerestory {
namespace {

template <class T>
std::string knobText(const T& value, const Range&) {
    return field::numberText(static_cast<double>(value));
}
std::string knobText(bool value, const Flag&) {
    return value ? "on" : "off";
}
template <class E>
std::string knobText(E value, const Choice<E>& choice) {
    return std::string(field::wordFor(choice, value));
}

// Name and value of every knob, in the table's order.
std::vector<std::pair<std::string, std::string>> knobsOf(const Accuracy& accuracy) {
    std::vector<std::pair<std::string, std::string>> knobs;
    Accuracy copy = accuracy;  // the tables visit values that may be written
    fields(copy, [&](const char* name, const auto& member, const auto& kind, const char*) {
        if (const auto* value = field::valueOf(member)) {
            knobs.emplace_back(name, knobText(*value, kind));
        }
    });
    return knobs;
}

}  // namespace

std::vector<FieldError> problems(const ComparisonRequest& request) {
    std::vector<FieldError> errors = problems(request.frame);
    const double pixels = static_cast<double>(request.frame.width) * request.frame.height;
    if (pixels * request.samples > kMaxPaths) {
        errors.push_back({"/samples", "gives too many paths for this frame size",
                          "width * height * samples of at most " + field::numberText(kMaxPaths)});
    }
    if (!request.frame.filters.empty()) {
        errors.push_back({"/filters", "are not supported: the reference has no filters",
                          "an empty list; the frame is compared before filtering"});
    }
    const FieldError budget{"/accuracy", "is a budget and cannot be compared",
                            "a preset or settings"};
    if (request.frame.accuracy.isBudget()) errors.push_back(budget);
    for (std::size_t i = 0; i < request.settings.size(); ++i) {
        if (!request.settings[i].isBudget()) continue;
        errors.push_back({"/settings/" + std::to_string(i), budget.detail, budget.allowed});
    }
    return errors;
}

std::vector<Accuracy> settingsOf(const ComparisonRequest& request) {
    std::vector<Accuracy> wanted = request.settings;
    if (wanted.empty()) {
        wanted = {request.frame.accuracy, accuracyOf(Preset::draft), accuracyOf(Preset::standard),
                  accuracyOf(Preset::fine)};
    }
    std::vector<Accuracy> settings;
    for (const Accuracy& a : wanted) {
        if (std::find(settings.begin(), settings.end(), a) == settings.end()) settings.push_back(a);
    }
    return settings;
}

std::string nameOf(const Accuracy& accuracy) {
    const auto knobs = knobsOf(accuracy), usual = knobsOf(accuracyOf(accuracy.preset));
    std::string text(field::wordFor(presetChoice(), accuracy.preset));
    for (const auto& knob : knobs) {
        if (std::find(usual.begin(), usual.end(), knob) == usual.end()) {
            text += ", " + knob.first + " " + knob.second;
        }
    }
    return text;
}

}  // namespace clerestory
