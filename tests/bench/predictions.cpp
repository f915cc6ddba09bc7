#include "predictions.h"

#include "accuracy_text.h"
#include "measures/percentile.h"

#include <cmath>

namespace clerestory::bench {
namespace {

constexpr Technique kTechniques[] = {
    {Effect::planarReflection, Method::environment,
     [](Accuracy& a) { a.planar = PlanarMethod::environment; }},
    {Effect::planarReflection, Method::mirror,
     [](Accuracy& a) { a.planar = PlanarMethod::mirror; }},
    {Effect::planarReflection, Method::traced,
     [](Accuracy& a) { a.planar = PlanarMethod::traced; }},
    {Effect::environmentReflection, Method::environment,
     [](Accuracy& a) { a.curved = CurvedMethod::environment; }},
    {Effect::environmentReflection, Method::probe,
     [](Accuracy& a) { a.curved = CurvedMethod::probe; }},
    {Effect::environmentReflection, Method::traced,
     [](Accuracy& a) { a.curved = CurvedMethod::traced; }},
    {Effect::refraction, Method::environment,
     [](Accuracy& a) { a.glass = GlassMethod::environment; }},
    {Effect::refraction, Method::backdrop, [](Accuracy& a) { a.glass = GlassMethod::backdrop; }},
    {Effect::refraction, Method::traced, [](Accuracy& a) { a.glass = GlassMethod::traced; }},
};

constexpr double kDistinct = 1.25, kSame = 1.05;

// Root mean square error of the chosen techniques; nothing if none was chosen.
std::optional<double> expectedError(const FramePlan& plan, const Technique& way) {
    double squares = 0.0, share = 0.0;
    bool taken = false;
    for (const Decision& d : plan.decisions) {
        if (d.effect != way.effect) continue;
        for (const Candidate& c : d.candidates) {
            if (c.method == d.taken) squares += d.share * c.error * c.error;
        }
        share += d.share;
        taken = taken || d.taken == way.method;
    }
    if (!taken || share <= 0.0) return std::nullopt;
    return std::sqrt(squares / share);
}

std::string nameOf(const Prediction& p) {
    return std::string(clerestory::nameOf(p.effect)) + ", " +
           std::string(clerestory::nameOf(p.method));
}

}  // namespace

std::span<const Technique> techniques() {
    return kTechniques;
}

std::vector<Prediction> measurePredictions(const FrameRequest& frame, const ReferenceImage& truth,
                                           const DrawFrame& draw) {
    FrameRequest linear = frame;
    linear.output = {.format = OutputFormat::npy};
    FrameRequest masks = maskRequest(frame);
    masks.output = {.format = OutputFormat::npy, .channel = Channel::through};
    const Image through = draw(masks).image;
    std::vector<Prediction> predictions;
    for (const Technique& way : kTechniques) {
        const Mask mask = maskOf(through, way.effect);
        if (mask.pixels() == 0) continue;
        FrameRequest request = linear;
        way.request(request.accuracy);
        const DrawnFrame drawn = draw(request);
        const std::optional<double> expected = expectedError(drawn.plan, way);
        if (!expected) continue;
        predictions.push_back(
            {.effect = way.effect,
             .method = way.method,
             .predicted = *expected,
             .measured = std::sqrt(linearErrors(drawn.image, truth.color, &mask).relMse),
             .noise = std::sqrt(relMseNoise(truth, &mask))});
    }
    return predictions;
}

Agreement agreementOf(const std::vector<Prediction>& predictions) {
    Agreement result;
    for (const Prediction& better : predictions) {
        for (const Prediction& worse : predictions) {
            if (better.effect != worse.effect) continue;
            if (better.predicted * kDistinct >= worse.predicted) continue;
            ++result.pairs;
            if (better.measured > kSame * worse.measured + 2.0 * better.noise) {
                result.reversed.push_back(nameOf(better) + text(": %.3g, but ", better.measured) +
                                          nameOf(worse) + text(": %.3g", worse.measured));
            }
        }
    }
    return result;
}

std::string textOf(const std::vector<Prediction>& predictions) {
    if (predictions.empty()) return "Nothing in view leaves a choice.\n";
    std::string out =
        "| way | predicted | measured | of the truth's noise | measured / predicted "
        "|\n|---|---|---|---|---|\n";
    std::vector<double> ratios;
    for (const Prediction& p : predictions) {
        ratios.push_back(p.measured / p.predicted);
        out += "| " + nameOf(p) +
               text(" | %.3g | %.3g | %.2g | %.2f |\n", p.predicted, p.measured, p.noise,
                    ratios.back());
    }
    const double middle = std::max(median(ratios), 1e-9);
    double worst = 1.0;
    for (const double r : ratios) {
        worst = std::max({worst, r / middle, middle / std::max(r, 1e-9)});
    }
    out += text("\nMedian ratio %.2f; the worst is %.2f times as far off.", middle, worst);
    const Agreement agreement = agreementOf(predictions);
    out += text(" Of %d pairs of ways %zu are the other way round.\n", agreement.pairs,
                agreement.reversed.size());
    for (const std::string& line : agreement.reversed) out += "- " + line + "\n";
    return out;
}

}  // namespace clerestory::bench
