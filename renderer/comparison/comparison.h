// What accuracies cost and how far each is from the truth, for one view of one scene. Draws through
// a function, so that it knows neither OpenGL nor whose thread owns it.
#pragma once

#include "comparison/comparison_request.h"
#include "measures/displayed_errors.h"
#include "measures/linear_errors.h"
#include "plan/graph/frame_plan.h"

#include <memory>

namespace clerestory {

struct DrawnFrame {
    Image image;
    double milliseconds = 0.0;  // of wall clock round finished work; not in a queue
    FramePlan plan;
};
using DrawFrame = std::function<DrawnFrame(const FrameRequest&)>;

struct ReferenceRender {
    ReferenceImage image;
    double milliseconds = 0.0;  // that tracing it took
};

struct EffectErrors {
    Effect effect = Effect::base;
    LinearErrors errors;       // on the pixels whose first surface carries the effect
    double relMseOff = 0.0;    // there, with this effect off and all else at standard
    double relMseNoise = 0.0;  // there, of the truth itself
    double closedGap = 0.0;
};

struct SettingResult {
    Accuracy accuracy;
    std::string name;     // nameOf(accuracy)
    double coldMs = 0.0;  // the first frame, with programs to compile and maps to draw
    double medianMs = 0.0, p95Ms = 0.0;  // of warm frames
    double predictedMs = 0.0;   // the plan's own, for what its decisions chose between; 0: nothing
    PlanTotals totals;          // of a warm frame
    LinearErrors frame;         // linear radiance before tone mapping
    DisplayedErrors displayed;  // of what a display shows, before JPEG
    double closedGap = 0.0;
    std::vector<EffectErrors> effects;  // those that are on and that the view shows
    double jpegPsnr = 0.0;              // of the JPEG against the picture it was made of
    Image errorPicture;                 // srgb8, when asked for
};

struct Comparison {
    ReferenceMode mode = ReferenceMode::effects;
    std::uint32_t samples = 0, seed = 0;
    double truthMs = 0.0;
    double relMseNoise = 0.0;  // of the truth: no error below five times this is to be believed
    double relMseOff = 0.0;    // with every effect off
    std::uint64_t nonFinite =
        0;  // numbers of the truth that were not finite; 0 unless there is a bug
    std::vector<SettingResult> settings;  // as settingsOf() has them
};

// relMSE of the truth's own noise, over a mask or the whole picture: what is below it says nothing.
double relMseNoise(const ReferenceImage& truth, const Mask* mask = nullptr);

// `scene` may be without texels. `progress` gets the share that is done, 0..1; once it returns
// false nothing is returned. Throws what `draw` throws.
std::optional<Comparison> compare(const ComparisonRequest& request, const Scene& scene,
                                  const ReferenceRender& truth, const DrawFrame& draw,
                                  const std::function<bool(double)>& progress = {});

}  // namespace clerestory
