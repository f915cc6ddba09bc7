#include "comparison/comparison.h"

#include "image/encode.h"
#include "measures/displayed.h"
#include "measures/error_picture.h"
#include "measures/percentile.h"
#include "scene/material_override.h"

#include <algorithm>
#include <cmath>

namespace clerestory {
namespace {

FrameRequest inChannel(FrameRequest request, Channel channel) {
    request.output = {.format = OutputFormat::npy, .channel = channel};
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
};

// What all settings of one comparison are held against.
struct Yardstick {
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

// Tells how far the work is at every frame, and ends it when nobody wants it.
class Steps {
public:
    struct Ended {};
    Steps(std::size_t count, const DrawFrame& draw, const std::function<bool(double)>& told)
        : count_(count), draw_(draw), told_(told) {}
    DrawnFrame draw(const FrameRequest& request) {
        DrawnFrame frame = draw_(request);
        ++done_;
        const double share = static_cast<double>(done_) / static_cast<double>(count_);
        if (told_ && !told_(std::min(share, 1.0))) throw Ended{};
        return frame;
    }

private:
    std::size_t count_, done_ = 0;
    const DrawFrame& draw_;
    const std::function<bool(double)>& told_;
};

class Comparing {
public:
    Comparing(const ComparisonRequest& request, const Scene& scene, const ReferenceRender& truth,
              Steps& steps)
        : request_(request), scene_(scene), truth_(truth), steps_(steps) {}

    // The frame first, then each effect that is on and seen.
    std::vector<Yardstick> yardsticks() const {
        FrameRequest base = request_.frame;
        base.accuracy = accuracyOf(Preset::standard);
        const FrameRequest masks = maskRequest(request_.frame);
        const Image through = steps_.draw(inChannel(masks, Channel::through)).image;
        const Image ids = steps_.draw(inChannel(masks, Channel::objectId)).image;
        const auto yardstick = [&](Effect effect, std::optional<Mask> mask, const Effects& off) {
            const Mask* where = mask ? &*mask : nullptr;
            FrameRequest without = base;
            without.effects = off;
            const Image& truth = truth_.image.color;
            const Image picture = steps_.draw(linear(without)).image;
            const double relMseOff = linearErrors(picture, truth, where).relMse;
            const double noise = relMseNoise(truth_.image, where);
            return Yardstick{effect, std::move(mask), relMseOff, noise};
        };
        std::vector<Yardstick> all;
        all.push_back(yardstick(Effect::base, std::nullopt, {false, false, false, false}));
        for (const EffectSwitch& s : kSwitches) {
            if (!(request_.frame.effects.*s.on)) continue;
            Mask mask =
                s.effect == Effect::emission
                    ? emissionMask(ids, scene_, bindMaterials(scene_, request_.frame.overrides))
                    : maskOf(through, s.effect);
            if (mask.pixels() == 0) continue;
            Effects off = request_.frame.effects;
            off.*s.on = false;
            all.push_back(yardstick(s.effect, std::move(mask), off));
        }
        return all;
    }

    SettingResult timed(const Accuracy& accuracy) const {
        SettingResult result{.accuracy = accuracy, .name = nameOf(accuracy)};
        FrameRequest request = request_.frame;
        request.accuracy = accuracy;
        request.output = {.format = OutputFormat::png};
        result.coldMs = steps_.draw(request).milliseconds;
        std::vector<double> warm;
        DrawnFrame last;
        for (std::uint32_t i = 0; i < request_.frames; ++i) {
            last = steps_.draw(request);
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
        const Image shown = displayed(truth_.image.color, request_.frame.toneMap,
                                      static_cast<float>(std::exp2(request_.frame.exposure)));
        result.displayed = displayedErrors(last.image, shown);
        const Output& output = request_.frame.output;
        result.jpegPsnr = psnr(decodeJpeg(encodeJpeg(last.image, static_cast<int>(output.quality),
                                                     output.subsampling == Subsampling::s420)),
                               last.image);
        return result;
    }

    void measure(SettingResult& result, const std::vector<Yardstick>& yardsticks) const {
        FrameRequest request = request_.frame;
        request.accuracy = result.accuracy;
        const Image picture = steps_.draw(linear(request)).image;
        for (const Yardstick& y : yardsticks) {
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
    Steps& steps_;
};

}  // namespace

double relMseNoise(const ReferenceImage& truth, const Mask* mask) {
    Image moved = truth.color;  // by its noise, which is then its distance
    const std::size_t count = std::size_t{moved.width} * moved.height * moved.channels;
    for (std::size_t k = 0; k < count; ++k) moved.floats()[k] += truth.noise.floats()[k];
    return linearErrors(moved, truth.color, mask).relMse;
}

std::optional<Comparison> compare(const ComparisonRequest& request, const Scene& scene,
                                  const ReferenceRender& truth, const DrawFrame& draw,
                                  const std::function<bool(double)>& progress) {
    const std::vector<Accuracy> settings = settingsOf(request);
    // Masks, frames without effects, and for each setting a cold, the warm and a linear one.
    const std::size_t frames =
        2 + 1 + std::size(kSwitches) + settings.size() * (request.frames + 2);
    Steps steps(frames, draw, progress);
    const Comparing comparing(request, scene, truth, steps);
    try {
        const std::vector<Yardstick> yardsticks = comparing.yardsticks();
        Comparison result{.mode = request.mode,
                          .samples = truth.image.samples,
                          .seed = request.seed,
                          .truthMs = truth.milliseconds,
                          .relMseNoise = yardsticks.front().relMseNoise,
                          .relMseOff = yardsticks.front().relMseOff,
                          .nonFinite = truth.image.nonFinite};
        for (const Accuracy& accuracy : settings) {
            result.settings.push_back(comparing.timed(accuracy));
            comparing.measure(result.settings.back(), yardsticks);
        }
        return result;
    } catch (const Steps::Ended&) {
        return std::nullopt;
    }
}

}  // namespace clerestory
