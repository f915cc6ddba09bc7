#include "comparison/comparison.h"

#include "image/image.h"
#include "measures/errors.h"
#include "measures/percentile.h"
#include "scene/fields.h"
#include "scene/material_override.h"

#include <algorithm>
#include <cmath>

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

FrameRequest inChannel(FrameRequest request, Channel channel) {
    request.output = {.format = OutputFormat::npy, .channel = channel};
    request.background.reset();
    return request;
}
FrameRequest linear(const FrameRequest& request) {
    return inChannel(request, Channel::color);
}

struct EffectSwitch {
    Effect effect;
    bool Effects::*on;
};
constexpr EffectSwitch kSwitches[] = {
    {Effect::emission, &Effects::emission},
    {Effect::refraction, &Effects::refraction},
    {Effect::planarReflection, &Effects::planarReflection},
    {Effect::environmentReflection, &Effects::environmentReflection},
    {Effect::materialLayers, &Effects::materialLayers},
    {Effect::shadows, &Effects::shadows},
    {Effect::indirectLight, &Effects::indirectLight},
};

// Pixels whose first surface shows the effect; all surfaces show shadows and light.
Mask maskFor(Effect effect, const Image& ids, const Image& through, const Scene& scene,
             const FrameRequest& frame) {
    const auto materials = [&] {
        const Pose pose = poseAt(scene, *clipsNamed(scene, frame.clip), frame.time);
        return bindMaterials(scene, pose, frame.overrides, frame.variant);
    };
    switch (effect) {
        case Effect::emission:
            return emissionMask(ids, scene, materials());
        case Effect::materialLayers:
            return layersMask(ids, scene, materials());
        case Effect::shadows:
        case Effect::indirectLight:
            return modelMask(ids);
        default:
            return maskOf(through, effect);
    }
}

// The baseline that the errors of all settings are related to.
struct Baseline {
    Effect effect = Effect::base;
    std::optional<Mask> mask;  // none: the whole frame
    double relMseOff = 0.0, relMseNoise = 0.0;

    EffectErrors errors(const Image& picture, const Image& truth) const {
        EffectErrors e{.effect = effect, .relMseOff = relMseOff, .relMseNoise = relMseNoise};
        e.errors = linearErrors(picture, truth, mask ? &*mask : nullptr);
        e.closedGap = closedGap(e.errors.relMse, relMseOff, relMseNoise);
        return e;
    }
};

// Draws frames, reports progress after each, and throws Cancelled if the callback returns false.
class ProgressDraw {
public:
    struct Cancelled {};
    ProgressDraw(std::size_t count, const DrawFrame& draw,
                 const std::function<bool(double)>& progress)
        : count_(count), draw_(draw), progress_(progress) {}
    DrawnFrame draw(const FrameRequest& request) {
        DrawnFrame frame = draw_(request);
        ++done_;
        const double share = static_cast<double>(done_) / static_cast<double>(count_);
        if (progress_ && !progress_(std::min(share, 1.0))) throw Cancelled{};
        return frame;
    }

private:
    std::size_t count_, done_ = 0;
    const DrawFrame& draw_;
    const std::function<bool(double)>& progress_;
};

class SettingComparison {
public:
    SettingComparison(const ComparisonRequest& request, const Scene& scene,
                      const ReferenceRender& truth, ProgressDraw& frames)
        : request_(request), scene_(scene), truth_(truth), frames_(frames) {}

    // The whole frame first, then each effect that is on and visible.
    std::vector<Baseline> baselines() {
        FrameRequest base = request_.frame;
        base.accuracy = accuracyOf(Preset::standard);
        const FrameRequest masks = maskRequest(request_.frame);
        const Image through = frames_.draw(inChannel(masks, Channel::through)).image;
        const Image ids = frames_.draw(inChannel(masks, Channel::objectId)).image;
        model_ = modelMask(ids);
        const auto baseline = [&](Effect effect, std::optional<Mask> mask, const Effects& off) {
            const Mask* pixels = mask ? &*mask : nullptr;
            FrameRequest without = base;
            without.effects = off;
            const Image& truth = truth_.image.color;
            const Image picture = frames_.draw(linear(without)).image;
            const double relMseOff = linearErrors(picture, truth, pixels).relMse;
            const double noise = relMseNoise(truth_.image, pixels);
            return Baseline{effect, std::move(mask), relMseOff, noise};
        };
        std::vector<Baseline> all;
        all.push_back(baseline(Effect::base, std::nullopt,
                               {false, false, false, false, false, false, false}));
        for (const EffectSwitch& s : kSwitches) {
            if (!(request_.frame.effects.*s.on)) continue;
            Mask mask = maskFor(s.effect, ids, through, scene_, request_.frame);
            if (mask.pixels() == 0) continue;
            Effects off = request_.frame.effects;
            off.*s.on = false;
            all.push_back(baseline(s.effect, std::move(mask), off));
        }
        return all;
    }

    SettingResult timed(const Accuracy& accuracy) const {
        SettingResult result{.accuracy = accuracy, .name = nameOf(accuracy)};
        FrameRequest request = request_.frame;
        request.accuracy = accuracy;
        request.output = {.format = OutputFormat::png};
        result.coldMs = frames_.draw(request).milliseconds;
        std::vector<double> warm;
        DrawnFrame last;
        for (std::uint32_t i = 0; i < request_.frames; ++i) {
            last = frames_.draw(request);
            warm.push_back(last.milliseconds);
        }
        result.medianMs = median(warm);
        result.p95Ms = percentile(warm, 0.95);
        result.totals = totals(last.plan);
        for (const Decision& d : last.plan.decisions) {
            for (const Candidate& c : d.candidates) {
                if (c.method == d.taken) result.predictedMs += c.milliseconds;
            }
        }
        const Image truthDisplayed =
            displayed(truth_.image.color, request_.frame.toneMap,
                      static_cast<float>(std::exp2(request_.frame.exposure)));
        result.displayed = displayedErrors(last.image, truthDisplayed);
        result.modelDecibels = decibels(last.image, truthDisplayed, &model_);
        const Output& output = request_.frame.output;
        result.jpegPsnr = psnr(decodeJpeg(encodeJpeg(last.image, static_cast<int>(output.quality),
                                                     output.subsampling == Subsampling::s420)),
                               last.image);
        return result;
    }

    void measure(SettingResult& result, const std::vector<Baseline>& baselines) const {
        FrameRequest request = request_.frame;
        request.accuracy = result.accuracy;
        const Image picture = frames_.draw(linear(request)).image;
        for (const Baseline& y : baselines) {
            const EffectErrors errors = y.errors(picture, truth_.image.color);
            if (y.mask) {
                result.effects.push_back(errors);
            } else {
                result.frame = errors.errors;
                result.closedGap = errors.closedGap;
            }
        }
        if (request_.errorPictures) result.errorPicture = errorPicture(picture, truth_.image.color);
    }

private:
    const ComparisonRequest& request_;
    const Scene& scene_;
    const ReferenceRender& truth_;
    ProgressDraw& frames_;
    Mask model_;
};

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
    if (const auto& ground = request.frame.ground; ground && ground->shadowCatcher == true) {
        errors.push_back({"/ground/shadowCatcher", "is not supported: the reference has none",
                          "false; the ground is compared as a surface"});
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

double relMseNoise(const ReferenceImage& truth, const Mask* mask) {
    Image noisy = truth.color;  // displaced by its noise estimate
    const std::size_t count = std::size_t{noisy.width} * noisy.height * noisy.channels;
    for (std::size_t k = 0; k < count; ++k) noisy.floats()[k] += truth.noise.floats()[k];
    return linearErrors(noisy, truth.color, mask).relMse;
}

std::optional<Comparison> compare(const ComparisonRequest& request, const Scene& scene,
                                  const ReferenceRender& truth, const DrawFrame& draw,
                                  const std::function<bool(double)>& progress) {
    const std::vector<Accuracy> settings = settingsOf(request);
    // Two masks, frames with effects off, and for each setting a cold, the warm and a linear frame.
    const std::size_t frameCount =
        2 + 1 + std::size(kSwitches) + settings.size() * (request.frames + 2);
    ProgressDraw progressDraw(frameCount, draw, progress);
    const Composition composition = compositionOf(linear(request.frame));
    const std::optional<Scene> own =
        composition.empty() ? std::nullopt : std::optional(composed(scene, composition));
    SettingComparison comparison(request, own ? *own : scene, truth, progressDraw);
    try {
        const std::vector<Baseline> baselines = comparison.baselines();
        Comparison result{.mode = request.mode,
                          .samples = truth.image.samples,
                          .seed = request.seed,
                          .truthMs = truth.milliseconds,
                          .relMseNoise = baselines.front().relMseNoise,
                          .relMseOff = baselines.front().relMseOff,
                          .nonFinite = truth.image.nonFinite};
        for (const Accuracy& accuracy : settings) {
            result.settings.push_back(comparison.timed(accuracy));
            comparison.measure(result.settings.back(), baselines);
        }
        return result;
    } catch (const ProgressDraw::Cancelled&) {
        return std::nullopt;
    }
}

}  // namespace clerestory
