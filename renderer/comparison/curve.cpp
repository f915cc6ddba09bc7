#include "comparison/curve.h"

#include "measures/percentile.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace clerestory {
namespace {

constexpr std::uint32_t kSmallEdge = 320;
constexpr std::uint32_t kTruthSamples = 32;
constexpr int kWarmFrames = 3;
// Weight of one frame when refining a point.
constexpr double kRefinement = 0.2;

// The same view at reduced resolution.
FrameRequest reduced(const FrameRequest& frame) {
    FrameRequest request = frame;
    const double scale =
        std::min(1.0, static_cast<double>(kSmallEdge) / std::max(frame.width, frame.height));
    const auto scaled = [&](std::uint32_t edge) {
        return static_cast<std::uint32_t>(std::max(1.0, std::round(scale * edge)));
    };
    request.width = scaled(frame.width);
    request.height = scaled(frame.height);
    if (auto& lens = request.camera.intrinsics) {
        const double x = static_cast<double>(request.width) / frame.width;
        const double y = static_cast<double>(request.height) / frame.height;
        const double half = lens->pixelCenter == PixelCenter::integer ? 0.5 : 0.0;
        lens->fx *= x;
        lens->fy *= y;
        lens->cx = (lens->cx + half) * x - half;
        lens->cy = (lens->cy + half) * y - half;
    }
    return request;
}

FrameRequest with(FrameRequest request, const Accuracy& accuracy, OutputFormat format) {
    request.accuracy = accuracy;
    request.filters.clear();  // the truth has no filters
    request.output = {.format = format};
    return request;
}

std::string figures(const CurvePoint& point) {
    char text[64];
    std::snprintf(text, sizeof text, "%.0f ms, relMSE %.3g", point.milliseconds, point.relMse);
    return text;
}

}  // namespace

std::vector<Accuracy> curveSettings() {
    Accuracy least = accuracyOf(Preset::draft);
    least.planar = PlanarMethod::environment;
    least.curved = CurvedMethod::environment;
    least.glass = GlassMethod::environment;
    Accuracy smooth = accuracyOf(Preset::standard);
    smooth.samples = 4;
    smooth.edgeFilter = false;
    Accuracy single = accuracyOf(Preset::fine);
    single.samples = 1;
    single.edgeFilter = true;
    Accuracy traced = accuracyOf(Preset::fine);
    traced.curved = CurvedMethod::traced;
    traced.glass = GlassMethod::traced;
    return {least,
            accuracyOf(Preset::draft),
            accuracyOf(Preset::standard),
            smooth,
            single,
            accuracyOf(Preset::fine),
            traced};
}

std::optional<Curve> measureCurve(const FrameRequest& frame, const TraceTruth& trace,
                                  const DrawFrame& draw,
                                  const std::function<bool(double)>& progress) {
    const FrameRequest reducedFrame = reduced(frame);
    const auto truth = trace(reducedFrame, kTruthSamples);
    if (!truth) return std::nullopt;
    const std::vector<Accuracy> settings = curveSettings();
    Curve curve;
    for (std::size_t i = 0; i < settings.size(); ++i) {
        const double share = static_cast<double>(i) / static_cast<double>(settings.size());
        if (progress && !progress(kCurveTracingShare + (1.0 - kCurveTracingShare) * share)) {
            return std::nullopt;
        }
        CurvePoint point{.accuracy = settings[i]};
        const Image picture = draw(with(reducedFrame, settings[i], OutputFormat::npy)).image;
        point.relMse = linearErrors(picture, truth->color).relMse;
        const FrameRequest fullSize = with(frame, settings[i], OutputFormat::png);
        draw(fullSize);  // compiles programs and draws resident maps
        std::vector<double> warm;
        for (int k = 0; k < kWarmFrames; ++k) warm.push_back(draw(fullSize).milliseconds);
        point.milliseconds = median(warm);
        curve.points.push_back(point);
    }
    curve.relMseNoise = relMseNoise(*truth);
    return curve;
}

Chosen choose(const Curve& curve, const Accuracy& budget) {
    const auto& points = curve.points;
    const auto withinTime = [&](const CurvePoint& p) {
        return !budget.maxMilliseconds || p.milliseconds <= *budget.maxMilliseconds;
    };
    const auto withinError = [&](const CurvePoint& p) {
        return !budget.maxError || p.relMse <= *budget.maxError;
    };
    const auto cheaper = [](const CurvePoint& a, const CurvePoint& b) {
        return a.milliseconds < b.milliseconds;
    };
    const auto moreExact = [](const CurvePoint& a, const CurvePoint& b) {
        return a.relMse < b.relMse;
    };
    // The least point by `less` among those that `fits` accepts; points.end() if none.
    const auto best = [&](const auto& fits, const auto& less) {
        auto found = points.end();
        for (auto p = points.begin(); p != points.end(); ++p) {
            if (fits(*p) && (found == points.end() || less(*p, *found))) found = p;
        }
        return found;
    };
    const auto any = [](const CurvePoint&) { return true; };
    const auto both = [&](const CurvePoint& p) { return withinTime(p) && withinError(p); };
    auto found = budget.maxError ? best(both, cheaper) : best(withinTime, moreExact);
    const bool met = found != points.end();
    if (!met && budget.maxMilliseconds) found = best(withinTime, moreExact);
    if (found == points.end()) found = best(any, budget.maxMilliseconds ? cheaper : moreExact);

    Chosen chosen{.point = static_cast<std::size_t>(found - points.begin()), .met = met};
    chosen.words = nameOf(found->accuracy) + ": " + figures(*found) + " predicted";
    if (!met) chosen.words += "; no setting meets the budget";
    const auto mostExact = best(any, moreExact);
    if (mostExact != found && mostExact->relMse < found->relMse) {
        chosen.words +=
            "; not chosen: " + nameOf(mostExact->accuracy) + " with " + figures(*mostExact);
    }
    return chosen;
}

void refine(CurvePoint& point, double milliseconds) {
    if (!(milliseconds > 0.0) || !std::isfinite(milliseconds)) return;
    point.milliseconds += kRefinement * (milliseconds - point.milliseconds);
}

}  // namespace clerestory
